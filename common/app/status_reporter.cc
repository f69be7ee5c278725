#include "common/app/status_reporter.h"

#include <fmt/core.h>

#include <algorithm>

#include "common/app/supervision.h"
#include "common/bus/channels.h"
#include "common/bus/lcm_url.h"
#include "common/config/config_difference.h"
#include "common/core/digest.h"
#include "common/core/sleep.h"
#include "common/messages/codec.h"

namespace sprout {
namespace {

constexpr size_t kShownKeys = 10;

SproutConfig WithoutSource(SproutConfig config) {
  CaptureConfig& capture = *config.mutable_capture();
  capture.clear_source();
  capture.set_source(std::string(capture.source()));  // every field is set
  return config;
}

}  // namespace

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
  if (publisher_.Publish(channel, bytes)) {
    monitor_.StatusSent();
  } else {
    monitor_.NotSent(publisher_.failure());
  }
}

ProcessInfo LiveProcessInfo(const StageStatus& status, const SproutConfig& config) {
  return {.header = {},
          .stage = status.stage,
          .host = status.host,
          .version = status.version,
          .config_digest = status.config_digest,
          .config_text = ConfigText(config),
          .pid = status.pid};
}

ProcessInfo ReplayProcessInfo(const ServiceContext& context, int64_t utime) {
  const std::string text = ConfigText(WithoutSource(context.config));
  return {.header = {.utime = utime, .seq = -1, .rig_id = ""},
          .stage = context.stage,
          .host = "",
          .version = context.version,
          .config_digest = Digest(text),
          .config_text = text,
          .pid = 0};
}

std::optional<std::string> ConfigChangeText(const ServiceContext& context,
                                            const ProcessInfo& recorded) {
  const bool was_replay = recorded.pid == 0;
  const auto differences =
      ConfigDifferences(recorded.config_text,
                        ConfigText(was_replay ? WithoutSource(context.config) : context.config));
  if (differences.empty()) return std::nullopt;
  std::string text = fmt::format("{} was recorded with another configuration:", recorded.stage);
  for (size_t i = 0; i < std::min(differences.size(), kShownKeys); ++i) {
    const auto& [key, before, now] = differences[i];
    text += fmt::format("{} {} = {}, now {}", i == 0 ? "" : ";", key, before, now);
  }
  if (differences.size() > kShownKeys) {
    text += fmt::format("; and {} more", differences.size() - kShownKeys);
  }
  return text;
}

}  // namespace sprout
