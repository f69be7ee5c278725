#include "common/app/status_reporter.h"

#include "common/app/log.h"
#include "common/app/process_info.h"
#include "common/app/supervision.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/core/sleep.h"
#include "common/messages/codec.h"

namespace sprout {

StatusReporter::StatusReporter(const ServiceContext& context, StageMonitor& monitor)
    : process_(context.stage),
      monitor_(monitor),
      publisher_(context.lcm_url, context.prefix),
      info_(EncodeProcessInfo(LiveProcessInfo(monitor.Snapshot(), context.config))) {
  if (const auto warning = ReceiveBufferWarning(context.lcm_url)) monitor.HoldWarning(*warning);
  thread_ = std::jthread([this](const std::stop_token& stop) {
    StageMonitor::Clock::time_point next_info{};
    do {
      PublishStatus();
      if (StageMonitor::Clock::now() >= next_info) {
        Publish(kProcessChannel, info_);
        next_info = StageMonitor::Clock::now() + kInfoPeriod;
      }
    } while (SleepFor(std::chrono::seconds(1), stop));
  });
}

StatusReporter::~StatusReporter() {
  thread_.request_stop();
  thread_.join();
  monitor_.SetStopped();
  PublishStatus();
}

void StatusReporter::PublishStatus() {
  const StageStatus status = monitor_.Snapshot();
  if (status.stage == process_) NotifyStatus(status);
  Publish(kStatusChannel, EncodeStatus(status));
}

void StatusReporter::Publish(std::string_view channel, std::span<const uint8_t> bytes) {
  if (!publisher_.Publish(channel, bytes))
    LogLine(LogLevel::kWarning, "{}: could not be published", channel);
}

}  // namespace sprout
