#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "common/app/service_context.h"
#include "common/app/silence_watch.h"
#include "common/app/stage_monitor.h"
#include "common/bus/receiver.h"
#include "common/core/frame_id.h"

namespace sprout::capture {

/// Tracks what the graph answers to capture: which stages report, and which frames have a
/// disparity. Thread-safe.
class AnswerTracker {
 public:
  using Deadline = StageMonitor::Clock::time_point;

  /// Subscribes to SPROUT_STATUS and, with `disparities`, to SPROUT_DISPARITY. Stores only what was
  /// asked for, whatever arrives.
  /// @param stages  to wait for.
  /// @throws BusError, see OpenLcm().
  AnswerTracker(const ServiceContext& context, StageMonitor& monitor,
                const std::vector<std::string>& stages, bool disparities);

  /// Waits until every stage has reported.
  /// @returns the stages that have not reported: none, unless the deadline passed or a stop was
  ///          requested.
  std::set<std::string> WaitForStages(Deadline deadline, const std::stop_token& stop);

  /// Stages that have reported, the first few that did; without capture itself.
  std::set<std::string> reported();

  /// A frame is about to be sent; an answer with this FrameId is expected.
  void Expect(const FrameId& id);

  bool IsAnswered(const FrameId& id);

  /// Waits until at most `count` of the expected answers are missing, the deadline passes or a stop
  /// is requested.
  void WaitForRoom(size_t count, Deadline deadline, const std::stop_token& stop);

 private:
  static constexpr size_t kMaxReported = 16;

  void OnMessage(std::string_view channel, std::span<const uint8_t> bytes);
  void OnStatus(std::span<const uint8_t> bytes);
  void OnDisparity(std::span<const uint8_t> bytes);

  StageMonitor& monitor_;
  DuplicateWatch duplicates_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::set<std::string> silent_;    // stages that have not reported
  std::set<std::string> reported_;  // at most kMaxReported
  std::vector<FrameId> missing_;    // expected and not answered
  Receiver receiver_;               // last: stops before the rest is destroyed
};

/// When a frame is due: at a fixed rate, or at the recorded intervals. After a stall of more than
/// one interval all later frames are delayed, not sent in a burst, as with a camera.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param rate_hz  frames a second; 0 = at once.
  static Pace AtRate(double rate_hz) { return Pace(rate_hz); }
  static Pace AsRecorded() { return Pace(std::nullopt); }

  void Start(Clock::time_point now);

  /// When the next frame may be taken; for a recorded one at any time.
  Clock::time_point DueBeforeTaking() const;

  /// Whether a frame taken now, at a fixed rate, is more than an interval late.
  bool IsLate(Clock::time_point now) const;

  /// A frame is taken now.
  void Take(Clock::time_point now);

  /// When a frame that was taken may be sent. Call once a frame. Negative intervals, as when
  /// capture was started again, count as 0, and those above kLongestInterval as kLongestInterval.
  Clock::time_point DueBeforeSending(const FrameId& id, Clock::time_point now);

  static constexpr std::chrono::seconds kLongestInterval{10};

 private:
  explicit Pace(std::optional<double> rate_hz) : rate_hz_(rate_hz) {}

  // Time between frames; nothing where no rate is set, or 0.
  std::optional<Clock::duration> Period() const;

  std::optional<double> rate_hz_;  // nothing: as recorded
  Clock::time_point due_{};  // of the next frame at a fixed rate, of the newest one as recorded
  std::optional<int64_t> utime_;  // of the newest frame
};

}  // namespace sprout::capture
