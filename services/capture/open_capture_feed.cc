#include <optional>
#include <string>
#include <string_view>

#include "common/rig/rig_file.h"
#include "common/scenes/dataset.h"
#include "common/scenes/source_options.h"
#include "services/capture/capture_feed.h"
#include "services/capture/raw_source.h"
#include "services/capture/ros2/ros_feed.h"
#include "services/capture/source_feed.h"

namespace sprout::capture {
namespace {

constexpr std::string_view kLog = "log:";

void WarnOfViews(const CurrentRig& rig, StageMonitor& monitor) {
  const std::string warning = ViewsWarning(rig.Get()->rectifier.views());
  if (warning.empty()) return;
  monitor.Warn(warning);
  monitor.HoldWarning(warning);
}

std::unique_ptr<CaptureFeed> OpenLog(const std::string& source, bool loop, StageMonitor& monitor) {
  const auto [place, options] = scenes::SplitSource(source);
  const std::string path = place.substr(kLog.size());
  std::string prefix;
  std::optional<std::string> rig;
  for (const scenes::SourceOption& option : options) {
    if (option.name == "prefix") {
      prefix = option.value;
    } else if (option.name == "rig") {
      rig = std::string(option.value);
    } else {
      throw scenes::BadSource(source, "no such option " + std::string(option.text),
                              "?prefix=TEXT, ?rig=FILE");
    }
  }
  if (!rig) return OpenLogFeed(path, prefix, loop, monitor);
  auto current = std::make_shared<CurrentRig>(LoadRigFile(*rig), *rig);
  WarnOfViews(*current, monitor);
  return OpenRawLogFeed(path, prefix, std::move(current), loop, monitor);
}

std::unique_ptr<CaptureFeed> OpenCameraFeed(const CaptureConfig& config, const FeedOptions& options,
                                            StageMonitor& monitor) {
  OpenedCameras opened =
      OpenCameras(config.source(), options.loop, options.waiting, /*calibrated=*/!options.raw);
  if (options.raw) return RawFeedFrom(std::move(opened.cameras), config, monitor);
  if (!opened.rig) {
    throw scenes::BadSource(config.source(), "no calibration",
                            "?rig=FILE with one that sprout-calibrate has written, or --raw");
  }
  WarnOfViews(*opened.rig, monitor);
  return FeedFrom(Rectified(std::move(opened.cameras), opened.rig), config, monitor, opened.rig);
}

}  // namespace

std::unique_ptr<CaptureFeed> OpenCaptureFeed(const CaptureConfig& config,
                                             const FeedOptions& options, StageMonitor& monitor) {
  if (NamesCameras(config.source())) return OpenCameraFeed(config, options, monitor);
  if (NamesRos(config.source())) return OpenRosFeed(config, options, monitor);
  if (options.raw) {
    throw scenes::BadSource(config.source(), "--raw is for cameras",
                            "genicam:, opencv:, v4l2:, ros2:, mcap:");
  }
  if (config.source().starts_with(kLog)) return OpenLog(config.source(), options.loop, monitor);
  return FeedFrom(scenes::PlayDataset(scenes::OpenDataset(config), options.loop), config, monitor);
}

}  // namespace sprout::capture
