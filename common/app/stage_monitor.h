#ifndef SPROUT_COMMON_APP_STAGE_MONITOR_H_
#define SPROUT_COMMON_APP_STAGE_MONITOR_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "common/app/log_limiter.h"
#include "common/core/frame_id.h"
#include "common/core/stage_status.h"

namespace sprout {

/// Time since 1970-01-01 UTC, µs: the clock of header.utime.
int64_t NowUtime();

/// Counts what happens in one process, for its status, and logs what goes wrong, each kind at most
/// once a second. Nothing is lost without a count here. Thread-safe.
class StageMonitor {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param now  tells the time; tests have their own.
  StageMonitor(const std::string& stage, const std::string& config_digest,
               std::function<Clock::time_point()> now = Clock::now);

  /// A complete frame is in hand; `skipped` when it took the place of one that was not worked on.
  void FrameIn(bool skipped);

  /// A frame was answered. Warns of one that was captured in the future: then the clock of this
  /// host and that of the capture's differ, and no age is true.
  /// @param arrived     when it was complete.
  /// @param degenerate  why it has no result; empty when all is well.
  /// @param tof_coverage  see TofCoverage(); kUnknownCoverage from who sees no seeds.
  void FrameOut(const FrameId& id, Clock::time_point arrived, const std::string& degenerate,
                float tof_coverage = kUnknownCoverage);

  /// The stage failed on a frame.
  void FrameFailed(const FrameId& id, const std::string& reason);

  /// Capture sent a frame again.
  void FrameResent(const FrameId& id);

  /// A message did not pass the border.
  void BadMessage(std::string_view channel, const std::string& reason);

  /// A message was dropped since too many wait for this process; counts as a bad one.
  void MessageDropped(std::string_view channel);

  /// Something else went wrong.
  void Failure(const std::string& reason);

  /// Nothing went wrong here, but people should know.
  void Warn(const std::string& reason);

  /// As Warn(), without a line of log.
  void Remember(const std::string& reason);

  /// How far the ToF camera's points are off; one that is not known leaves the newest that was.
  /// Warns once a minute of one that is beyond doubt.
  void SetTofOffset(const TofOffsetStatus& offset);

  /// Between the exposures of the newest frame, ms.
  void SetSpread(double spread_ms);

  /// Counts of the joiner, which keeps them itself.
  void SetJoinerCounts(int64_t incomplete, int64_t sequence_gaps);

  /// The last status of a process says so.
  void SetStopped();

  StageStatus Snapshot() const;

 private:
  struct Sample {
    Clock::time_point finished;
    double latency_ms;
    double age_ms;
  };

  std::function<Clock::time_point()> now_;
  mutable std::mutex mutex_;
  StageStatus status_;          // without rate and times, which Snapshot() adds
  std::deque<Sample> samples_;  // of the newest frames
  LogLimiter bad_message_log_;
  LogLimiter degenerate_log_;
  LogLimiter failed_log_;
  LogLimiter clock_log_;
  Clock::time_point next_offset_warning_{};
};

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_STAGE_MONITOR_H_
