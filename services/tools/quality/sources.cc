#include "services/tools/quality/sources.h"

#include <fmt/core.h>

#include <algorithm>
#include <vector>

#include "common/app/progress.h"
#include "common/config/config_error.h"
#include "common/config/frame_range.h"
#include "common/core/input_files.h"
#include "common/core/interrupt.h"
#include "common/frames/log_frames.h"
#include "common/scenes/middlebury_calibration.h"
#include "common/scenes/pfm.h"

namespace sprout::quality {
namespace {

namespace fs = std::filesystem;

bool IsFull(const Measurement& measurement) {
  return !measurement.empty() && measurement.meter().frames() == measurement.settings().count;
}

bool IsDisparityMap(const fs::path& path) {
  return path.filename().string().ends_with("disparity.pfm");
}

std::vector<fs::path> FilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

// The maps one level down: `sprout-pipeline files` writes a folder for each of many pairs.
std::vector<fs::path> MapsBelow(const fs::path& folder) {
  std::vector<fs::path> maps;
  for (const fs::path& path : FilesIn(folder)) {
    if (fs::is_directory(path) && fs::is_regular_file(path / "disparity.pfm")) {
      maps.push_back(path / "disparity.pfm");
    }
  }
  return maps;
}

std::vector<fs::path> MapsIn(const fs::path& folder) {
  std::vector<fs::path> all;
  for (const fs::path& path : FilesIn(folder)) {
    if (path.extension() == ".pfm") all.push_back(path);
  }
  if (all.empty()) return MapsBelow(folder);
  std::vector<fs::path> disparities;
  std::ranges::copy_if(all, std::back_inserter(disparities), IsDisparityMap);
  return disparities.empty() ? all : disparities;
}

// The calibration of a map when none was named: beside the map, else in the folder that was named.
fs::path CalibrationOf(const fs::path& map, const fs::path& folder) {
  std::error_code ignored;
  const fs::path beside = map.parent_path() / "calib.txt";
  return fs::exists(beside, ignored) ? beside : folder / "calib.txt";
}

// Empty where a frame has none, or a picture in its place.
cv::Mat1b SigmaOf(const Frame& frame) {
  return frame.sigma.type() == CV_8UC1 ? cv::Mat1b(frame.sigma) : cv::Mat1b();
}

}  // namespace

void AddFrame(const Frame& frame, Measurement& measurement) {
  if (!frame.rig) {
    measurement.AddWithoutCalibration();
    return;
  }
  measurement.Add(
      {.disparity_px = ToPx(*frame.disparity), .sigma = SigmaOf(frame), .pair = frame.rig->pair});
}

std::string MeasureLog(const fs::path& log, const std::string& prefix, const std::string& frames,
                       Measurement& measurement) {
  const Interrupt interrupt;
  FrameChoice choice{.prefix = prefix, .parts = {Part::kDisparity, Part::kSigma, Part::kRig}};
  if (!frames.empty()) choice.frames = ParseFrameRange("--frames", frames);
  int64_t refused = 0;
  std::string first_refusal;
  LogFrames reader(log, choice, [&](const LogEvent& event, const std::string& why) {
    if (refused++ == 0) first_refusal = fmt::format("{}: {}", event.channel, why);
  });
  Progress progress(/*quiet=*/false);
  const auto check = [](int64_t) { Interrupt::Check(); };
  while (!IsFull(measurement)) {
    const std::optional<Frame> frame = reader.Next(check);
    if (!frame) break;
    if (frame->disparity) AddFrame(*frame, measurement);
    if (!measurement.empty()) {
      progress.Show(fmt::format("{}: {} maps", log.string(), measurement.meter().frames()));
    }
  }
  std::string complaint;
  if (refused > 0)
    complaint = fmt::format("{} messages cannot be read ({})", refused, first_refusal);
  if (const size_t damaged = reader.log().damage().size(); damaged > 0) {
    complaint += fmt::format("{}damaged in {} places", complaint.empty() ? "" : "; ", damaged);
  }
  if (!measurement.empty()) return complaint;
  std::string why = measurement.without_calibration() > 0
                        ? "no calibration (SPROUT_RIG) for its disparity maps"
                        : "no frame with SPROUT_DISPARITY";
  for (const std::string& more : {reader.index().OtherPrefixText(), complaint}) {
    if (!more.empty()) why += "; " + more;
  }
  throw ConfigError(fmt::format("{}: {}; allowed: a log with the answers of grow and SPROUT_RIG",
                                log.string(), why));
}

void NoteFolderFiles(const fs::path& folder, const fs::path& calibration) {
  if (!calibration.empty()) NoteInputFile(calibration);
  for (const fs::path& map : MapsIn(folder)) {
    NoteInputFile(map);
    if (calibration.empty()) NoteInputFile(CalibrationOf(map, folder));
  }
}

void MeasureFolder(const fs::path& folder, const fs::path& calibration, Measurement& measurement) {
  const Interrupt interrupt;
  const std::vector<fs::path> maps = MapsIn(folder);
  if (maps.empty()) {
    throw ConfigError(folder.string() +
                      ": no *.pfm in it, nor a disparity.pfm in a folder of it; allowed: a log, a "
                      "folder of disparity maps (px), or one that sprout-pipeline files wrote");
  }
  for (const fs::path& path : maps) {
    Interrupt::Check();
    if (IsFull(measurement)) break;
    const fs::path calib = calibration.empty() ? CalibrationOf(path, folder) : calibration;
    const cv::Mat1f map = scenes::ReadPfm(path);
    measurement.Add({.disparity_px = map,
                     .sigma = {},
                     .pair = scenes::CalibrationFromCalib(calib, map.size())});
  }
}

}  // namespace sprout::quality
