#include "services/quality/sources.h"

#include <fmt/core.h>

#include <algorithm>
#include <vector>

#include "common/app/progress.h"
#include "common/config/config_error.h"
#include "common/config/frame_range.h"
#include "common/core/input_files.h"
#include "common/core/interrupt.h"
#include "common/frames/log_frames.h"
#include "services/datasets/middlebury_calibration.h"
#include "services/datasets/pfm.h"

namespace sprout::quality {
namespace {

namespace fs = std::filesystem;

bool IsFull(const Measurement& measurement) {
  return !measurement.empty() && measurement.meter().frames() == measurement.settings().count;
}

std::vector<fs::path> MapsIn(const fs::path& folder) {
  std::vector<fs::path> all;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".pfm") all.push_back(entry.path());
  }
  std::ranges::sort(all);
  std::vector<fs::path> disparities;
  std::ranges::copy_if(all, std::back_inserter(disparities), [](const fs::path& path) {
    return path.filename().string().ends_with("disparity.pfm");
  });
  return disparities.empty() ? all : disparities;
}

fs::path CalibrationIn(const fs::path& folder, const fs::path& calibration) {
  return calibration.empty() ? folder / "calib.txt" : calibration;
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
  for (const fs::path& map : MapsIn(folder)) NoteInputFile(map);
  NoteInputFile(CalibrationIn(folder, calibration));
}

void MeasureFolder(const fs::path& folder, const fs::path& calibration, Measurement& measurement) {
  const Interrupt interrupt;
  const std::vector<fs::path> maps = MapsIn(folder);
  if (maps.empty()) {
    throw ConfigError(folder.string() +
                      ": no *.pfm in it; allowed: a log, or a folder of disparity "
                      "maps (px)");
  }
  const fs::path calib = CalibrationIn(folder, calibration);
  for (const fs::path& path : maps) {
    Interrupt::Check();
    if (IsFull(measurement)) break;
    const cv::Mat1f map = datasets::ReadPfm(path);
    measurement.Add({.disparity_px = map,
                     .sigma = {},
                     .pair = datasets::CalibrationFromCalib(calib, map.size())});
  }
}

}  // namespace sprout::quality
