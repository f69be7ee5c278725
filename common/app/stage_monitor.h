#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/app/log_limiter.h"
#include "common/core/frame_id.h"
#include "common/core/stage_status.h"

namespace sprout {

/// Time since 1970-01-01 UTC, µs: the clock of header.utime.
int64_t NowUtime();

/// Counts the events of one process, for its status, and logs errors, each kind at most once a
/// second. Every loss is counted here. The newest error stands in the status until frames have been
/// answered for a minute without a loss; one that goes on, until it is over. Thread-safe.
class StageMonitor {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param now  returns the time; tests replace it.
  StageMonitor(const std::string& stage, const std::string& config_digest,
               std::function<Clock::time_point()> now = Clock::now);

  /// The frames are those of a recording: this host's clock does not judge them.
  void SetReplay() { is_replay_ = true; }

  /// A complete frame arrived; `skipped` if it replaced one that was not processed.
  void FrameIn(bool skipped);

  /// A frame that arrived was replaced by a newer one before any work on it.
  void FrameSkipped();

  /// A frame was answered. Warns if it was captured in the future: then the clocks of this host and
  /// of capture's host differ, and ages are wrong.
  /// @param arrived     when it was complete.
  /// @param degenerate  why it has no result; empty when all is well.
  /// @param tof_coverage  see TofCoverage(); kUnknownCoverage if the stage sees no seeds.
  void FrameOut(const FrameId& id, Clock::time_point arrived, const std::string& degenerate,
                float tof_coverage = kUnknownCoverage);

  /// The stage failed on a frame.
  void FrameFailed(const FrameId& id, const std::string& reason);

  /// A frame was not sent, or its answer; see NotSent().
  void FrameNotSent(const FrameId& id, const std::string& reason);

  /// A message was not sent. While more and more are not, as where the network is away, the log has
  /// one line when that begins, and one when it is over.
  void NotSent(const std::string& reason);

  /// A status was sent: once nothing has failed for two seconds, what NotSent() told is over.
  void StatusSent();

  /// Counts captures that became no frame.
  void CapturesFailed(int64_t count, const std::string& reason);

  /// Capture sent a frame again.
  void FrameResent(const FrameId& id);

  /// A message was refused by the checks.
  void BadMessage(std::string_view channel, const std::string& reason);

  /// A message was dropped because too many wait for this process; counts as a bad one.
  void MessageDropped(std::string_view channel);

  /// Reports an error that is none of the above.
  void Failure(const std::string& reason);

  /// A warning that is not an error of this process.
  void Warn(const std::string& reason);

  /// Shows a warning in the status, as Warn() does, but writes no line to the log.
  void RecordWarning(const std::string& reason);

  /// A warning of something that goes on, until Resolve(): the status shows it again when a newer
  /// error is over. Writes no line to the log.
  void HoldWarning(const std::string& reason);

  /// Ends a warning: the status shows no error any more, unless another one came meanwhile, or is
  /// held.
  void Resolve(const std::string& reason);

  /// The calibration of the frame of which the findings below are; with another one than before
  /// those of the range sensor are over.
  void SetRig(const std::string& rig_id);

  /// The offset of the ToF camera's points; an unknown one does not replace the last known one.
  /// Warns once a minute if it is sure, until the offset is small again.
  void SetTofOffset(const TofOffsetStatus& offset);

  /// See StageResult::finding. The status has the newest one, unless another error came since; the
  /// log has one a minute.
  void SetFinding(const std::optional<std::string>& text);

  /// Time between the exposures of the newest frame, ms.
  void SetSpread(double spread_ms);

  /// Takes over the counts of the frame joiner.
  void SetJoinerCounts(int64_t incomplete, int64_t sequence_gaps);

  /// Sets the program's version in the statuses, if it is not Version().
  void SetVersion(const std::string& version);

  /// Marks the last status of a process.
  void SetStopped();

  StageStatus Snapshot() const;

 private:
  struct Sample {
    Clock::time_point finished;
    double latency_ms;
    double age_ms;
  };

  // A warning of this object that holds; empty: it does not.
  struct OwnWarning {
    std::string text = {};
    bool logged = false;               // the log has a line of it, and so gets one when it is over
    Clock::time_point next_line = {};  // of one that goes on and on
  };

  void SkippedLocked();
  void NotSentLocked(const std::string& reason);
  void TellLocked(const std::string& error);
  void HoldLocked(std::string& held, const std::string& text, bool show);
  std::string NewestHeldLocked() const;
  double RateLocked() const;
  void EndLocked(const std::string& held);
  void LogLocked(OwnWarning& warning);
  void ResolveLocked(OwnWarning& warning);

  std::function<Clock::time_point()> now_;
  mutable std::mutex mutex_;
  StageStatus status_;          // without rate and times, which Snapshot() adds
  std::deque<Sample> samples_;  // of the newest frames
  LogLimiter bad_message_log_;
  LogLimiter degenerate_log_;
  LogLimiter failed_log_;
  LogLimiter clock_log_;
  LogLimiter over_log_;   // of Resolve()
  int64_t not_sent_ = 0;  // messages, since that began; 0: all are sent
  Clock::time_point newest_not_sent_{};
  Clock::time_point trouble_{};    // the newest error or loss
  std::vector<std::string> held_;  // warnings that hold now, the newest last
  OwnWarning clock_warning_;
  OwnWarning offset_warning_;
  OwnWarning finding_;
  std::string rig_id_;  // of SetRig()
  bool is_replay_ = false;
};

}  // namespace sprout
