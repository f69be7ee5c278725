#include <chrono>
#include <fstream>
#include <optional>
#include <vector>

#include "common/app/log.h"
#include "common/app/log_limiter.h"
#include "common/app/service.h"
#include "common/app/silence_watch.h"
#include "common/app/status_reporter.h"
#include "common/app/supervision.h"
#include "common/bus/channels.h"
#include "common/bus/receiver.h"
#include "common/core/digest.h"
#include "common/core/sleep.h"
#include "common/ros/ros_node.h"
#include "services/ros2/bridge.h"

namespace sprout::ros2 {
namespace {

// Some ten frames of 2 MP may wait; with more the newest would be late.
constexpr size_t kMaxQueuedBytes = size_t{64} << 20;
// How soon a new subscriber gets something.
constexpr std::chrono::milliseconds kPollPeriod{200};

// Warns if a subscriber's socket gets too small a buffer for the burst of datagrams of a large
// message.
void WarnOfSmallBuffer() {
  constexpr int kEnough = 8 << 20;
  int bytes = kEnough;  // stays where the file is missing, as in a network namespace
  std::ifstream("/proc/sys/net/core/rmem_default") >> bytes;
  if (bytes >= kEnough) return;
  LogLine(LogLevel::kWarning,
          "net.core.rmem_default = {}: best-effort subscribers on this host lose most messages "
          "above {} kB; sudo scripts/setup, or sudo sysctl net.core.rmem_default={}",
          bytes, bytes / 1000, kEnough);
}

int Run(const ServiceContext& context) {
  StageMonitor monitor(context.stage, Digest(ConfigText(context.config)));
  LimitedWarnings of_dds;
  const RosWarnings warnings([&](const std::string& text, bool is_of_message) {
    is_of_message ? monitor.BadMessage("ROS 2", text) : of_dds.Warn(text);
  });
  WarnOfSmallBuffer();
  Bridge bridge(context.config.ros2(), context.config.depth(), monitor);
  const StatusReporter reporter(context, monitor);
  NotifyReady();
  Watchdog watchdog;
  std::set<std::string_view> channels;
  std::optional<SilenceWatch> silence;
  std::optional<Receiver> receiver;
  auto next_diagnostics = std::chrono::steady_clock::now();
  while (!context.stop.stop_requested()) {
    watchdog.Idle();
    // Only what somebody wants is taken from the bus.
    if (std::set<std::string_view> wanted = bridge.WantedChannels(); wanted != channels) {
      channels = std::move(wanted);
      receiver.reset();
      bridge.ReceivesOnly(channels);
      std::vector<std::string_view> of_frames(channels.begin(), channels.end());
      std::erase(of_frames, kStatusChannel);
      if (silence) silence->HeardFrame();  // ends its warnings: other channels are wanted now
      silence.emplace(context, of_frames, monitor);
      receiver.emplace(
          context.lcm_url, context.prefix,
          std::vector<std::string_view>(channels.begin(), channels.end()),
          [&](std::string_view channel, std::span<const uint8_t> bytes) {
            if (channel != kStatusChannel) silence->HeardSingle(channel);
            bridge.OnMessage(channel, bytes);
          },
          [&](std::string_view channel) { monitor.MessageDropped(channel); }, kMaxQueuedBytes);
    }
    if (std::chrono::steady_clock::now() >= next_diagnostics) {
      bridge.PublishDiagnostics();
      next_diagnostics += std::chrono::seconds(1);
    }
    SleepFor(kPollPeriod, context.stop);
  }
  receiver.reset();  // it calls the bridge
  return 0;
}

int Main(int argc, char** argv) {
  Service service("ros2",
                  "Shows the graph to ROS 2, without ROS: publishes images, camera infos, depth,\n"
                  "points, disparities, confidence, /tf_static and /diagnostics over DDS. What\n"
                  "nobody subscribes to is not converted.");
  std::optional<int> domain;
  bool best_effort = false;
  bool compressed = false;
  service.flags().Add("--domain N", domain, "In place of the environment's ROS_DOMAIN_ID");
  service.flags().Add("--compressed", compressed,
                      "Also JPEG of the images and compressedDepth of the depth");
  service.flags().Add("--best-effort", best_effort, "Do not send again what was lost");
  return service.Run(argc, argv, Run, [&](SproutConfig& config) {
    if (!domain) domain = RosDomainOfEnvironment();
    if (domain) config.mutable_ros2()->set_domain(*domain);
    if (compressed) config.mutable_ros2()->set_compressed(true);
    if (best_effort) config.mutable_ros2()->set_reliable(false);
  });
}

}  // namespace
}  // namespace sprout::ros2

int main(int argc, char** argv) { return sprout::ros2::Main(argc, argv); }
