#include "common/app/process_info.h"

#include <fmt/core.h>

#include <algorithm>

#include "common/config/config_difference.h"
#include "common/core/digest.h"

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
