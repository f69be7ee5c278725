#include <utility>

#include "common/core/checks.h"
#include "common/core/printable.h"
#include "common/messages/convert.h"

namespace sprout {
namespace {

constexpr int64_t kMaxCount = int64_t{1} << 53;

TimeSummary MakeTimes(double p50, double p95, double p99, double max) {
  return {.p50_ms = p50, .p95_ms = p95, .p99_ms = p99, .max_ms = max};
}

}  // namespace

stage_status_t ToMessage(const StageStatus& status) {
  stage_status_t message;
  message.header = ToMessage(status.newest_frame);
  message.stage = Shortened(status.stage, kMaxNameLength);
  message.host = Shortened(status.host, kMaxTextLength);
  message.version = Shortened(status.version, kMaxTextLength);
  message.config_digest = Shortened(status.config_digest, kMaxTextLength);
  message.last_error = Shortened(status.last_error, kMaxTextLength);
  message.pid = status.pid;
  message.state = static_cast<int32_t>(status.state);
  message.frames_in = status.frames_in;
  message.frames_out = status.frames_out;
  message.frames_skipped = status.frames_skipped;
  message.frames_incomplete = status.frames_incomplete;
  message.frames_degenerate = status.frames_degenerate;
  message.frames_failed = status.frames_failed;
  message.frames_resent = status.frames_resent;
  message.bad_messages = status.bad_messages;
  message.sequence_gaps = status.sequence_gaps;
  message.rate_hz = status.rate_hz;
  message.latency_p50_ms = status.latency.p50_ms;
  message.latency_p95_ms = status.latency.p95_ms;
  message.latency_p99_ms = status.latency.p99_ms;
  message.latency_max_ms = status.latency.max_ms;
  message.age_p50_ms = status.age.p50_ms;
  message.age_p95_ms = status.age.p95_ms;
  message.age_p99_ms = status.age.p99_ms;
  message.age_max_ms = status.age.max_ms;
  message.rss_bytes = status.rss_bytes;
  message.tof_coverage = status.tof_coverage;
  message.spread_ms = status.spread_ms;
  message.tof_offset_u_px = status.tof_offset.u_px;
  message.tof_offset_v_px = status.tof_offset.v_px;
  message.tof_offset_sigma_px = status.tof_offset.sigma_px;
  return message;
}

Result<StageStatus> FromMessage(const stage_status_t& message) {
  Result<FrameId> newest_frame = FromMessage(message.header);
  if (!newest_frame) return tl::unexpected(newest_frame.error());
  Checks checks;
  checks
      .Require(message.state >= stage_status_t::STATE_READY &&
                   message.state <= stage_status_t::STATE_STOPPED,
               "state", message.state, "READY, RUNNING or STOPPED")
      .Require(message.tof_coverage == kUnknownCoverage ||
                   (message.tof_coverage >= 0 && message.tof_coverage <= 1),
               "tof_coverage", message.tof_coverage, "0 to 1, or -1 for not known")
      .Finite("rate_hz", message.rate_hz)
      .Finite("latency_p50_ms", message.latency_p50_ms)
      .Finite("latency_p95_ms", message.latency_p95_ms)
      .Finite("latency_p99_ms", message.latency_p99_ms)
      .Finite("latency_max_ms", message.latency_max_ms)
      .Finite("age_p50_ms", message.age_p50_ms)
      .Finite("age_p95_ms", message.age_p95_ms)
      .Finite("age_p99_ms", message.age_p99_ms)
      .Finite("age_max_ms", message.age_max_ms)
      .Finite("spread_ms", message.spread_ms)
      .Finite("tof_offset_u_px", message.tof_offset_u_px)
      .Finite("tof_offset_v_px", message.tof_offset_v_px)
      .Finite("tof_offset_sigma_px", message.tof_offset_sigma_px)
      .Length("stage", message.stage, kMaxNameLength)
      .Length("host", message.host, kMaxTextLength)
      .Length("version", message.version, kMaxTextLength)
      .Length("config_digest", message.config_digest, kMaxTextLength)
      .Length("last_error", message.last_error, kMaxTextLength);
  for (const auto& [field, count] : {std::pair{"frames_in", message.frames_in},
                                     {"frames_out", message.frames_out},
                                     {"frames_skipped", message.frames_skipped},
                                     {"frames_incomplete", message.frames_incomplete},
                                     {"frames_degenerate", message.frames_degenerate},
                                     {"frames_failed", message.frames_failed},
                                     {"frames_resent", message.frames_resent},
                                     {"bad_messages", message.bad_messages},
                                     {"sequence_gaps", message.sequence_gaps}}) {
    // Sums of them, which are shown, do not overflow.
    checks.Require(count >= 0 && count <= kMaxCount, field, count, "0 to 2^53");
  }
  if (!checks.ok()) return checks.error();
  return StageStatus{
      .newest_frame = *newest_frame,
      .stage = message.stage,
      .host = message.host,
      .version = message.version,
      .config_digest = message.config_digest,
      .last_error = message.last_error,
      .pid = message.pid,
      .state = static_cast<StageStatus::State>(message.state),
      .frames_in = message.frames_in,
      .frames_out = message.frames_out,
      .frames_skipped = message.frames_skipped,
      .frames_incomplete = message.frames_incomplete,
      .frames_degenerate = message.frames_degenerate,
      .frames_failed = message.frames_failed,
      .frames_resent = message.frames_resent,
      .bad_messages = message.bad_messages,
      .sequence_gaps = message.sequence_gaps,
      .rate_hz = message.rate_hz,
      .latency = MakeTimes(message.latency_p50_ms, message.latency_p95_ms, message.latency_p99_ms,
                           message.latency_max_ms),
      .age =
          MakeTimes(message.age_p50_ms, message.age_p95_ms, message.age_p99_ms, message.age_max_ms),
      .rss_bytes = message.rss_bytes,
      .tof_coverage = message.tof_coverage,
      .spread_ms = message.spread_ms,
      .tof_offset = {.u_px = message.tof_offset_u_px,
                     .v_px = message.tof_offset_v_px,
                     .sigma_px = message.tof_offset_sigma_px},
  };
}

process_info_t ToMessage(const ProcessInfo& info) {
  process_info_t message;
  message.header = ToMessage(info.header);
  message.stage = Shortened(info.stage, kMaxNameLength);
  message.host = Shortened(info.host, kMaxTextLength);
  message.version = Shortened(info.version, kMaxTextLength);
  message.config_digest = Shortened(info.config_digest, kMaxTextLength);
  message.config_text = Shortened(info.config_text, kMaxConfigLength);
  message.pid = info.pid;
  return message;
}

Result<ProcessInfo> FromMessage(const process_info_t& message) {
  Result<FrameId> header = FromMessage(message.header);
  if (!header) return tl::unexpected(header.error());
  Checks checks;
  checks.Length("stage", message.stage, kMaxNameLength)
      .Length("host", message.host, kMaxTextLength)
      .Length("version", message.version, kMaxTextLength)
      .Length("config_digest", message.config_digest, kMaxTextLength)
      .Length("config_text", message.config_text, kMaxConfigLength);
  if (!checks.ok()) return checks.error();
  return ProcessInfo{.header = *std::move(header),
                     .stage = message.stage,
                     .host = message.host,
                     .version = message.version,
                     .config_digest = message.config_digest,
                     .config_text = message.config_text,
                     .pid = message.pid};
}

}  // namespace sprout
