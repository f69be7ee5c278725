// Takes the place of ros2/ros_feed.cc in a build without ROS 2.
#include "common/config/left_out.h"
#include "services/capture/ros2/ros_feed.h"

namespace sprout::capture {

std::shared_ptr<void> TakeRosWarnings(StageMonitor&) { return nullptr; }

std::unique_ptr<CaptureFeed> OpenRosFeed(const CaptureConfig& config, const FeedOptions&,
                                         StageMonitor&) {
  throw LeftOut("capture.source = " + config.source(), "ROS2");
}

}  // namespace sprout::capture
