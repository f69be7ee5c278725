#include <fmt/core.h>

#include <string>
#include <utility>
#include <vector>

#include "common/ros/to_ros.h"

namespace sprout {
namespace {

constexpr uint8_t kOk = 0;
constexpr uint8_t kWarn = 1;
constexpr uint8_t kError = 2;

std::vector<std::pair<std::string, std::string>> ValuesOf(const StageStatus& status) {
  return {{"newest frame", fmt::format("{}", status.newest_frame.seq)},
          {"frames in", fmt::format("{}", status.frames_in)},
          {"frames out", fmt::format("{}", status.frames_out)},
          {"frames skipped", fmt::format("{}", status.frames_skipped)},
          {"frames incomplete", fmt::format("{}", status.frames_incomplete)},
          {"frames degenerate", fmt::format("{}", status.frames_degenerate)},
          {"frames failed", fmt::format("{}", status.frames_failed)},
          {"bad messages", fmt::format("{}", status.bad_messages)},
          {"sequence gaps", fmt::format("{}", status.sequence_gaps)},
          {"rate (Hz)", fmt::format("{:.2f}", status.rate_hz)},
          {"latency p95 (ms)", fmt::format("{:.1f}", status.latency.p95_ms)},
          {"age p95 (ms)", fmt::format("{:.1f}", status.age.p95_ms)},
          {"memory (MB)", fmt::format("{:.1f}", static_cast<double>(status.rss_bytes) / 1e6)},
          {"version", status.version}};
}

void Set(const StageStatus& status, RosDiagnostic& ros) {
  const bool has_stopped = status.state == StageStatus::State::kStopped;
  const bool is_fine = status.last_error.empty();
  ros.level = has_stopped ? kError : is_fine ? kOk : kWarn;
  SetRosText(ros.name, "sprout: " + status.stage);
  SetRosText(ros.message, has_stopped ? "stopped" : is_fine ? "running" : status.last_error);
  SetRosText(ros.hardware_id, status.host);
  const auto values = ValuesOf(status);
  const std::span all = ResizeRos(ros.values, values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    SetRosText(all[i].key, values[i].first);
    SetRosText(all[i].value, values[i].second);
  }
}

}  // namespace

RosMessage<RosDiagnostics> ToRosDiagnostics(int64_t utime,
                                            const std::map<std::string, StageStatus>& statuses) {
  RosMessage<RosDiagnostics> ros;
  ros->header.stamp = RosStamp(utime);
  const std::span all = ResizeRos(ros->status, statuses.size());
  size_t next = 0;
  for (const auto& [name, status] : statuses) Set(status, all[next++]);
  return ros;
}

}  // namespace sprout
