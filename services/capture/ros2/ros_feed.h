#pragma once

#include <memory>
#include <string_view>

#include "services/capture/capture_feed.h"

namespace sprout::capture {

/// Whether a source is ros2: or mcap:.
inline bool NamesRos(std::string_view source) {
  return source.starts_with("ros2:") || source.starts_with("mcap:");
}

/// While it lives what DDS has to say goes to the log and, what is wrong with a message, to
/// `monitor`. Null when built without ROS 2.
std::shared_ptr<void> TakeRosWarnings(StageMonitor& monitor);

/// What OpenCaptureFeed() opens of such a source. @throws ConfigError also when built without
/// ROS 2.
std::unique_ptr<CaptureFeed> OpenRosFeed(const CaptureConfig& config, const FeedOptions& options,
                                         StageMonitor& monitor);

}  // namespace sprout::capture
