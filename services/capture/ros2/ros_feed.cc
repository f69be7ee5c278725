#include "services/capture/ros2/ros_feed.h"

#include <string>
#include <utility>

#include "common/app/log_limiter.h"
#include "common/ros/ros_node.h"
#include "services/capture/ros2/ros_source.h"
#include "services/capture/source_feed.h"

namespace sprout::capture {
namespace {

class WarningsTaker {
 public:
  explicit WarningsTaker(StageMonitor& monitor)
      : taken_([this, &monitor](const std::string& text, bool is_of_message) {
          is_of_message ? monitor.BadMessage("ROS 2", text) : of_dds_.Warn(text);
        }) {}

 private:
  LimitedWarnings of_dds_;
  RosWarnings taken_;
};

}  // namespace

std::shared_ptr<void> TakeRosWarnings(StageMonitor& monitor) {
  return std::make_shared<WarningsTaker>(monitor);
}

std::unique_ptr<CaptureFeed> OpenRosFeed(const CaptureConfig& config, const FeedOptions& options,
                                         StageMonitor& monitor) {
  const RosSourceOptions ros{
      .loop = options.loop,
      .waiting = options.waiting,
      .reports = {.tell = [&monitor](const std::string& what) { monitor.Failure(what); },
                  .refused = [&monitor](const std::string& topic,
                                        const std::string& why) { monitor.BadMessage(topic, why); },
                  .lost =
                      [&monitor](const scenes::LostFrames& lost) {
                        monitor.CapturesFailed(lost.count, lost.trouble);
                      }},
      .stop = options.stop};
  if (options.raw) return RawFeedFrom(OpenRawRosSource(config.source(), ros), config, monitor);
  std::unique_ptr<scenes::FrameSource> source = OpenRosSource(config.source(), ros);
  return source ? FeedFrom(std::move(source), config, monitor) : nullptr;
}

}  // namespace sprout::capture
