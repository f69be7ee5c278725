#include "common/app/stage_monitor.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include "common/app/log.h"
#include "common/app/version.h"
#include "common/core/host_name.h"

namespace sprout {
namespace {

constexpr size_t kMaxSamples = 1024;  // as lcmtypes/stage_status_t.lcm says
constexpr std::chrono::seconds kRateWindow{10};
constexpr std::chrono::minutes kWarningPeriod{1};  // of a sensor that stays wrong
// How long an error of a single frame is told while frames are answered again without a loss.
constexpr std::chrono::minutes kErrorShown{1};
// Statuses, of which one a second is sent, show that a network is there again, but not that images
// are sent that are too large for it.
constexpr std::chrono::seconds kAllSent{2};
constexpr double kClockSlackMs = 1;  // within one host a clock may be set by so much at a time
// From one frame to the next an age changes by the time of a frame. By more than this: frames come
// from another source, as when cameras follow a recording, or a stage hung; what was before would
// be shown as the present state for the 1024 frames to come.
constexpr double kOtherSourceMs = 10'000;

double Milliseconds(StageMonitor::Clock::duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

// Second number of statm: resident pages.
int64_t ResidentBytes() {
  int64_t total_pages = 0;
  int64_t resident_pages = 0;
  std::ifstream("/proc/self/statm") >> total_pages >> resident_pages;
  return resident_pages * sysconf(_SC_PAGESIZE);
}

// Nearest-rank percentiles.
TimeSummary Summarise(std::vector<double> times_ms) {
  if (times_ms.empty()) return {};
  std::sort(times_ms.begin(), times_ms.end());
  const auto rank = [&](double share) {
    const auto index = static_cast<size_t>(std::ceil(share * static_cast<double>(times_ms.size())));
    return times_ms[std::max<size_t>(index, 1) - 1];
  };
  return {
      .p50_ms = rank(0.50), .p95_ms = rank(0.95), .p99_ms = rank(0.99), .max_ms = times_ms.back()};
}

std::string FutureText(int64_t seq, double age_ms) {
  return fmt::format(
      "frame {} was captured {:.3f} s in the future by this host's clock: synchronise the clocks "
      "of both hosts (NTP, PTP), or, if this one's was set back, start capture again; until then "
      "ages are wrong",
      seq, -age_ms / 1000);
}

}  // namespace

int64_t NowUtime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

StageMonitor::StageMonitor(const std::string& stage, const std::string& config_digest,
                           std::function<Clock::time_point()> now)
    : now_(std::move(now)) {
  status_.stage = stage;
  status_.host = HostName();
  status_.version = Version();
  status_.config_digest = config_digest;
  status_.pid = getpid();
}

void StageMonitor::FrameIn(bool skipped) {
  const std::lock_guard lock(mutex_);
  ++status_.frames_in;
  if (skipped) SkippedLocked();
}

void StageMonitor::FrameSkipped() {
  const std::lock_guard lock(mutex_);
  SkippedLocked();
}

void StageMonitor::SkippedLocked() {
  ++status_.frames_skipped;
  trouble_ = now_();
}

void StageMonitor::FrameOut(const FrameId& id, Clock::time_point arrived,
                            const std::string& degenerate, float tof_coverage) {
  const auto now = now_();
  const Sample sample{.finished = now,
                      .latency_ms = Milliseconds(now - arrived),
                      .age_ms = static_cast<double>(NowUtime() - id.utime) / 1000};
  LogLine(LogLevel::kDebug, "frame {}: {:.1f} ms, age {:.1f} ms", id.seq, sample.latency_ms,
          sample.age_ms);
  const std::lock_guard lock(mutex_);
  ++status_.frames_out;
  status_.newest_frame = id;
  status_.tof_coverage = tof_coverage;
  status_.state = StageStatus::State::kRunning;
  if (!degenerate.empty()) {
    ++status_.frames_degenerate;
    TellLocked("frame " + std::to_string(id.seq) + ": " + degenerate);
    degenerate_log_.Log(LogLevel::kWarning, status_.last_error, now);
  }
  if (!is_replay_ && sample.age_ms < -kClockSlackMs) {
    HoldLocked(clock_warning_.text, FutureText(id.seq, sample.age_ms), true);
    if (clock_log_.Log(LogLevel::kWarning, clock_warning_.text, now)) clock_warning_.logged = true;
  } else {
    ResolveLocked(clock_warning_);
  }
  const bool holds = std::ranges::find(held_, status_.last_error) != held_.end();
  if (!holds && now - trouble_ >= kErrorShown) status_.last_error = NewestHeldLocked();
  if (!samples_.empty() && std::abs(samples_.back().age_ms - sample.age_ms) > kOtherSourceMs) {
    samples_.clear();
  }
  samples_.push_back(sample);
  if (samples_.size() > kMaxSamples) samples_.pop_front();
}

void StageMonitor::FrameFailed(const FrameId& id, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  ++status_.frames_failed;
  TellLocked("frame " + std::to_string(id.seq) + ": failed: " + reason);
  failed_log_.Log(LogLevel::kError, status_.last_error, now_());
}

void StageMonitor::FrameNotSent(const FrameId& id, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  ++status_.frames_failed;
  TellLocked("frame " + std::to_string(id.seq) + ": failed: " + reason);
  NotSentLocked(status_.last_error);
}

void StageMonitor::NotSent(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  NotSentLocked(reason);
}

void StageMonitor::NotSentLocked(const std::string& reason) {
  if (not_sent_ == 0) {
    LogLine(LogLevel::kError, "{}; what else is not sent is counted until that is over", reason);
  }
  ++not_sent_;
  newest_not_sent_ = now_();
}

void StageMonitor::StatusSent() {
  const std::lock_guard lock(mutex_);
  if (not_sent_ == 0 || now_() - newest_not_sent_ < kAllSent) return;
  LogLine(LogLevel::kWarning, "messages are sent again; {} could not be", not_sent_);
  not_sent_ = 0;
}

void StageMonitor::CapturesFailed(int64_t count, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  status_.frames_failed += count;
  TellLocked(reason);
  failed_log_.Log(LogLevel::kError,
                  fmt::format("{} {} no frame: {}", count,
                              count == 1 ? "capture became" : "captures became", reason),
                  now_());
}

void StageMonitor::FrameResent(const FrameId& id) {
  LogLine(LogLevel::kWarning, "frame {}: no answer, sent again", id.seq);
  const std::lock_guard lock(mutex_);
  ++status_.frames_resent;
}

void StageMonitor::BadMessage(std::string_view channel, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  ++status_.bad_messages;
  TellLocked(std::string(channel) + ": " + reason);
  bad_message_log_.Log(LogLevel::kWarning, fmt::format("{}: message dropped: {}", channel, reason),
                       now_());
}

void StageMonitor::MessageDropped(std::string_view channel) {
  BadMessage(channel, "came faster than messages can be decoded here");
}

void StageMonitor::Failure(const std::string& reason) {
  LogLine(LogLevel::kError, reason);
  RecordWarning(reason);
}

void StageMonitor::Warn(const std::string& reason) {
  LogLine(LogLevel::kWarning, reason);
  RecordWarning(reason);
}

void StageMonitor::RecordWarning(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  TellLocked(reason);
}

void StageMonitor::HoldWarning(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  std::string held = reason;
  HoldLocked(held, reason, true);
}

void StageMonitor::Resolve(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  if (reason.empty()) return;
  EndLocked(reason);
  over_log_.Log(LogLevel::kInfo, "over: " + reason, now_());
}

void StageMonitor::TellLocked(const std::string& error) {
  status_.last_error = error;
  trouble_ = now_();
}

// Replaces the warning `held` by a new text, which is shown if `held` was.
void StageMonitor::HoldLocked(std::string& held, const std::string& text, bool show) {
  if (show || status_.last_error == held) status_.last_error = text;
  std::erase(held_, held);
  held_.push_back(text);
  held = text;
}

std::string StageMonitor::NewestHeldLocked() const { return held_.empty() ? "" : held_.back(); }

void StageMonitor::EndLocked(const std::string& held) {
  std::erase(held_, held);
  if (status_.last_error == held) status_.last_error = NewestHeldLocked();
}

void StageMonitor::LogLocked(OwnWarning& warning) {
  warning.next_line = now_() + kWarningPeriod;
  warning.logged = true;
  LogLine(LogLevel::kWarning, warning.text);
}

// Logs the end of a warning only if the log has its beginning: one that comes and goes with every
// frame is logged once a minute.
void StageMonitor::ResolveLocked(OwnWarning& warning) {
  if (warning.text.empty()) return;
  EndLocked(warning.text);
  if (warning.logged) LogLine(LogLevel::kInfo, "over: {}", warning.text);
  warning = {.next_line = warning.next_line};
}

void StageMonitor::SetRig(const std::string& rig_id) {
  const std::lock_guard lock(mutex_);
  if (rig_id == rig_id_) return;
  rig_id_ = rig_id;
  status_.tof_offset = {};
  ResolveLocked(offset_warning_);
  ResolveLocked(finding_);
}

void StageMonitor::SetTofOffset(const TofOffsetStatus& offset) {
  if (offset.sigma_px < 0) return;
  const std::lock_guard lock(mutex_);
  status_.tof_offset = offset;
  if (!offset.is_off) return ResolveLocked(offset_warning_);
  const bool is_due = now_() >= offset_warning_.next_line;
  if (!is_due && !offset_warning_.text.empty()) return;
  const std::string text = fmt::format(
      "the ToF camera's points are off by ({:.1f}, {:.1f}) px in the left image: calibrate again; "
      "refine {{ align_tof: true }} corrects it until then",
      -offset.u_px, -offset.v_px);
  HoldLocked(offset_warning_.text, text, true);
  if (is_due) LogLocked(offset_warning_);
}

void StageMonitor::SetFinding(const std::optional<std::string>& text) {
  if (!text) return;
  const std::lock_guard lock(mutex_);
  if (text->empty()) return ResolveLocked(finding_);
  const bool is_due = now_() >= finding_.next_line;
  HoldLocked(finding_.text, *text, is_due);
  if (is_due) LogLocked(finding_);
}

void StageMonitor::SetSpread(double spread_ms) {
  const std::lock_guard lock(mutex_);
  status_.spread_ms = static_cast<float>(spread_ms);
}

void StageMonitor::SetJoinerCounts(int64_t incomplete, int64_t sequence_gaps) {
  const std::lock_guard lock(mutex_);
  if (incomplete != status_.frames_incomplete || sequence_gaps != status_.sequence_gaps) {
    trouble_ = now_();
  }
  status_.frames_incomplete = incomplete;
  status_.sequence_gaps = sequence_gaps;
}

void StageMonitor::SetVersion(const std::string& version) {
  const std::lock_guard lock(mutex_);
  status_.version = version;
}

void StageMonitor::SetStopped() {
  const std::lock_guard lock(mutex_);
  status_.state = StageStatus::State::kStopped;
}

StageStatus StageMonitor::Snapshot() const {
  const std::lock_guard lock(mutex_);
  StageStatus status = status_;
  std::vector<double> latencies_ms;
  std::vector<double> ages_ms;
  for (const Sample& sample : samples_) {
    latencies_ms.push_back(sample.latency_ms);
    ages_ms.push_back(sample.age_ms);
  }
  status.latency = Summarise(std::move(latencies_ms));
  status.age = Summarise(std::move(ages_ms));
  status.rate_hz = RateLocked();
  status.rss_bytes = ResidentBytes();
  return status;
}

// Over the last kRateWindow; of frames that are farther apart, over the newest two, as long as the
// next one may still come.
double StageMonitor::RateLocked() const {
  if (samples_.size() < 2) return 0;
  const auto now = now_();
  auto first = std::ranges::find_if(
      samples_, [&](const Sample& sample) { return sample.finished >= now - kRateWindow; });
  const Clock::time_point newest = samples_.back().finished;
  if (samples_.end() - first < 2) {
    first = samples_.end() - 2;
    if (now - newest > 2 * (newest - first->finished)) return 0;
  }
  const double span_ms = Milliseconds(newest - first->finished);
  // Frames of one moment have no rate, and a status with an infinite one would be refused.
  return span_ms > 0 ? 1000 * static_cast<double>(samples_.end() - first - 1) / span_ms : 0;
}

}  // namespace sprout
