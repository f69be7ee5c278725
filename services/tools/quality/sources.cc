#include "services/tools/quality/sources.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <mutex>
#include <set>
#include <stdexcept>
#include <vector>

#include "common/app/progress.h"
#include "common/bus/lcm_url.h"
#include "common/bus/mailbox.h"
#include "common/bus/receiver.h"
#include "common/config/config_error.h"
#include "common/config/frame_range.h"
#include "common/core/input_files.h"
#include "common/core/signal_watcher.h"
#include "common/frames/frame_joiner.h"
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

// Whether it is a map that Sprout writes beside disparities: depths in m, standard deviations.
bool IsNoDisparityMap(const fs::path& path) {
  const std::string name = path.stem().string();
  return path.extension() != ".pfm" || name.ends_with("depth") || name.ends_with("sigma");
}

std::set<fs::path> FilesIn(const fs::path& folder) {
  return {fs::directory_iterator(folder), fs::directory_iterator()};
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
  std::ranges::remove_copy_if(FilesIn(folder), std::back_inserter(all), IsNoDisparityMap);
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

// The standard deviations of a frame; empty where it has none, or an image of another type.
cv::Mat1b SigmaOf(const Frame& frame) {
  return frame.sigma.type() == CV_8UC1 ? cv::Mat1b(frame.sigma) : cv::Mat1b();
}

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kRefresh{1};
constexpr std::chrono::seconds kPatience{30};  // with --once

// Frames on the bus that have a disparity map and a calibration, and standard deviations once such
// are heard.
class MapFrames {
 public:
  explicit MapFrames(const LiveOptions& options)
      : receiver_(options.lcm_url, options.prefix, Channels(),
                  [this](std::string_view channel, std::span<const uint8_t> bytes) {
                    OnMessage(channel, bytes);
                  }) {}

  std::optional<Frame> TakeWithin(std::chrono::milliseconds time, const std::stop_token& stop) {
    std::optional<Frame> frame = mailbox_.TakeWithin(time, stop);
    if (!frame) ExpectSigma(false);  // the process that sent SIGMA may have ended
    return frame;
  }

  /// Why the newest unusable message could not be used; empty: all could.
  std::string complaint() const {
    const std::lock_guard lock(mutex_);
    return complaint_;
  }

  int64_t skipped() const {
    const std::lock_guard lock(mutex_);
    return skipped_;
  }

 private:
  static std::vector<std::string_view> Channels() {
    return {ChannelOf(Part::kDisparity), ChannelOf(Part::kSigma), ChannelOf(Part::kRig)};
  }

  static FrameJoiner JoinerFor(bool with_sigma) {
    PartSet needed = {Part::kDisparity, Part::kRig};
    if (with_sigma) needed.Add(Part::kSigma);
    return FrameJoiner(needed);
  }

  // Pending messages are lost, and the calibration, which comes again within a second.
  void ExpectSigma(bool expected) {
    const std::lock_guard lock(mutex_);
    if (expected == with_sigma_) return;
    with_sigma_ = expected;
    joiner_ = JoinerFor(expected);
  }

  void OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
    const std::optional<Part> part = PartOf(channel);
    if (!part) return;
    if (part == Part::kSigma) ExpectSigma(true);
    const std::lock_guard lock(mutex_);
    Result<std::vector<Frame>> frames = joiner_.AddMessage(*part, bytes);
    if (!frames) {
      complaint_ = fmt::format("{}: {}", channel, frames.error().text);
      return;
    }
    for (Frame& frame : *frames) skipped_ += mailbox_.Put(std::move(frame)) ? 1 : 0;
  }

  mutable std::mutex mutex_;
  bool with_sigma_ = false;
  FrameJoiner joiner_ = JoinerFor(false);
  std::string complaint_;
  int64_t skipped_ = 0;
  Mailbox<Frame> mailbox_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

std::runtime_error NoMap(const MapFrames& frames, const std::string& when) {
  std::string text = "no disparity map with a calibration came" + when +
                     " (SPROUT_DISPARITY, SPROUT_RIG): is the graph running?";
  if (!frames.complaint().empty())
    text += " The last message that cannot be read: " + frames.complaint();
  return std::runtime_error(text);
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
    complaint += fmt::format("{}damaged in {} place{}", complaint.empty() ? "" : "; ", damaged,
                             damaged == 1 ? "" : "s");
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
                      ": no map of disparities (*.pfm) in it, nor a disparity.pfm in a folder of "
                      "it; allowed: a log, a "
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

void MeasureGraph(const LiveOptions& options, Measurement& measurement,
                  const std::function<void()>& refresh) {
  if (const auto error = LcmUrlError(options.lcm_url)) throw ConfigError("--lcm-url: " + *error);
  const SignalWatcher signals;
  MapFrames frames(options);
  Progress progress(/*quiet=*/false);
  progress.Show("waiting for disparity maps");
  Clock::time_point shown = Clock::now();
  Clock::time_point heard = shown;
  bool is_new = false;
  while (!signals.token().stop_requested()) {
    if (auto frame = frames.TakeWithin(kRefresh, signals.token())) {
      AddFrame(*frame, measurement);
      heard = Clock::now();
      is_new = true;
    }
    if (options.once && !measurement.empty() &&
        measurement.meter().frames() == measurement.settings().count) {
      break;
    }
    const Clock::time_point now = Clock::now();
    if (options.once && now - heard > kPatience) {
      throw NoMap(frames, fmt::format(" in {} s", kPatience.count()));
    }
    if (!is_new || now - shown < kRefresh) continue;
    progress.Clear();
    refresh();
    shown = now;
    is_new = false;
  }
  progress.Clear();
  if (measurement.empty()) throw NoMap(frames, "");
  if (!frames.complaint().empty()) std::cerr << "sprout-quality: " << frames.complaint() << "\n";
  if (frames.skipped() > 0) {
    std::cerr << "sprout-quality: " << frames.skipped()
              << " maps came faster than they were measured, and were left out\n";
  }
}

}  // namespace sprout::quality
