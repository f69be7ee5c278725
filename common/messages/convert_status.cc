#include <utility>

#include "common/core/checks.h"
#include "common/core/printable.h"
#include "common/messages/convert.h"

namespace sprout {
namespace {

constexpr int64_t kMaxCount = int64_t{1} << 53;

// The fields that a message and its value have alike, for `visit(name, message's, value's)`.
template <typename Message, typename Status, typename Visit>
void ForEachStatusCount(Message& message, Status& status, Visit visit) {
  visit("frames_in", message.frames_in, status.frames_in);
  visit("frames_out", message.frames_out, status.frames_out);
  visit("frames_skipped", message.frames_skipped, status.frames_skipped);
  visit("frames_incomplete", message.frames_incomplete, status.frames_incomplete);
  visit("frames_degenerate", message.frames_degenerate, status.frames_degenerate);
  visit("frames_failed", message.frames_failed, status.frames_failed);
  visit("frames_resent", message.frames_resent, status.frames_resent);
  visit("bad_messages", message.bad_messages, status.bad_messages);
  visit("sequence_gaps", message.sequence_gaps, status.sequence_gaps);
}

template <typename Message, typename Status, typename Visit>
void ForEachStatusReal(Message& message, Status& status, Visit visit) {
  visit("rate_hz", message.rate_hz, status.rate_hz);
  visit("latency_p50_ms", message.latency_p50_ms, status.latency.p50_ms);
  visit("latency_p95_ms", message.latency_p95_ms, status.latency.p95_ms);
  visit("latency_p99_ms", message.latency_p99_ms, status.latency.p99_ms);
  visit("latency_max_ms", message.latency_max_ms, status.latency.max_ms);
  visit("age_p50_ms", message.age_p50_ms, status.age.p50_ms);
  visit("age_p95_ms", message.age_p95_ms, status.age.p95_ms);
  visit("age_p99_ms", message.age_p99_ms, status.age.p99_ms);
  visit("age_max_ms", message.age_max_ms, status.age.max_ms);
  visit("spread_ms", message.spread_ms, status.spread_ms);
  visit("tof_offset_u_px", message.tof_offset_u_px, status.tof_offset.u_px);
  visit("tof_offset_v_px", message.tof_offset_v_px, status.tof_offset.v_px);
  visit("tof_offset_sigma_px", message.tof_offset_sigma_px, status.tof_offset.sigma_px);
}

template <typename Message, typename Status, typename Visit>
void ForEachStatusText(Message& message, Status& status, Visit visit) {
  visit("stage", message.stage, status.stage, kMaxNameLength);
  visit("host", message.host, status.host, kMaxTextLength);
  visit("version", message.version, status.version, kMaxTextLength);
  visit("config_digest", message.config_digest, status.config_digest, kMaxTextLength);
  if constexpr (requires { status.last_error; }) {
    visit("last_error", message.last_error, status.last_error, kMaxTextLength);
  } else {
    visit("config_text", message.config_text, status.config_text, kMaxConfigLength);
  }
}

constexpr auto kToMessage = [](const char*, auto& field, const auto& value) { field = value; };
constexpr auto kTextToMessage = [](const char*, std::string& field, const std::string& value,
                                   size_t longest) { field = Shortened(value, longest); };

// Takes the texts and refuses those that are too long.
template <typename Message, typename Status>
void TakeTexts(const Message& message, Status& status, Checks& checks) {
  ForEachStatusText(
      message, status,
      [&](const char* name, const std::string& field, std::string& value, size_t longest) {
        checks.Length(name, field, longest);
        value = field;
      });
}

}  // namespace

stage_status_t ToMessage(const StageStatus& status) {
  stage_status_t message;
  message.header = ToMessage(status.newest_frame);
  message.pid = status.pid;
  message.state = static_cast<int32_t>(status.state);
  message.rss_bytes = status.rss_bytes;
  message.tof_coverage = status.tof_coverage;
  ForEachStatusText(message, status, kTextToMessage);
  ForEachStatusCount(message, status, kToMessage);
  ForEachStatusReal(message, status, kToMessage);
  return message;
}

Result<StageStatus> FromMessage(const stage_status_t& message) {
  Result<FrameId> newest_frame = FromMessage(message.header);
  if (!newest_frame) return tl::unexpected(newest_frame.error());
  StageStatus status;
  status.newest_frame = *std::move(newest_frame);
  status.pid = message.pid;
  status.state = static_cast<StageStatus::State>(message.state);
  status.rss_bytes = message.rss_bytes;
  status.tof_coverage = message.tof_coverage;
  Checks checks;
  checks
      .Require(message.state >= stage_status_t::STATE_READY &&
                   message.state <= stage_status_t::STATE_STOPPED,
               "state", message.state, "READY, RUNNING or STOPPED")
      .Require(message.tof_coverage == kUnknownCoverage ||
                   (message.tof_coverage >= 0 && message.tof_coverage <= 1),
               "tof_coverage", message.tof_coverage, "0 to 1, or -1 for not known");
  ForEachStatusReal(message, status, [&](const char* name, auto field, auto& value) {
    checks.Finite(name, field);
    value = field;
  });
  TakeTexts(message, status, checks);
  ForEachStatusCount(message, status, [&](const char* name, int64_t field, int64_t& value) {
    // Sums of them, which are shown, do not overflow.
    checks.Require(field >= 0 && field <= kMaxCount, name, field, "0 to 2^53");
    value = field;
  });
  if (!checks.ok()) return checks.error();
  return status;
}

process_info_t ToMessage(const ProcessInfo& info) {
  process_info_t message;
  message.header = ToMessage(info.header);
  message.pid = info.pid;
  ForEachStatusText(message, info, kTextToMessage);
  return message;
}

Result<ProcessInfo> FromMessage(const process_info_t& message) {
  Result<FrameId> header = FromMessage(message.header);
  if (!header) return tl::unexpected(header.error());
  ProcessInfo info;
  info.header = *std::move(header);
  info.pid = message.pid;
  Checks checks;
  TakeTexts(message, info, checks);
  if (!checks.ok()) return checks.error();
  return info;
}

}  // namespace sprout
