#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>

#include "common/core/frame_id.h"

namespace sprout {

/// Frames between the first stage of a chain of three and the last one's answer. The first stage
/// begins a frame only while there are fewer than the slowest stage needs to be always at work.
/// Frames that come meanwhile replace each other before any work is spent on them, and what is
/// begun next is the newest one. services/pipeline/README.md has the rule and what follows from it.
///
/// Stages that are missing must not stop the first one: until a frame is answered any number may be
/// under way, and again when a frame is not answered for kPatience times as long as the slowest of
/// the newest kRemembered was. Thread-safe.
class FramesUnderWay {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr size_t kRemembered = 8;
  static constexpr int kPatience = 4;

  /// @param now  returns the time; tests replace it.
  explicit FramesUnderWay(std::function<Clock::time_point()> now = Clock::now)
      : now_(std::move(now)) {}

  /// The first stage is about to send its answer, on which it worked for `time`.
  void Sent(const FrameId& id, Clock::duration time);

  /// The second stage has answered. In a chain without one this is never called.
  void Passed(const FrameId& id);

  /// The last stage has answered: this frame, and those sent before it, are not under way any more.
  void Answered(const FrameId& id);

  /// Frames that may be in the chain: ⌈Σ T / max T⌉ of the three stages' times T, over the newest
  /// few answers; nothing while there was no answer.
  std::optional<size_t> Most() const;

  /// Waits until there is room, but not longer than `time`, and not once `stop` is requested.
  /// @returns whether there is.
  bool WaitForRoom(std::chrono::milliseconds time, const std::stop_token& stop);

 private:
  struct UnderWay {
    FrameId id;
    Clock::time_point sent;
    Clock::time_point reached_last;  // as far as is known
    Clock::duration first, second = {};
  };
  struct Times {
    Clock::duration first, second, last, behind_first;
  };

  std::optional<size_t> MostLocked() const;
  bool HasRoomLocked();
  Clock::duration Patience() const;

  std::function<Clock::time_point()> now_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<UnderWay> under_way_;  // in the order in which they were sent
  std::deque<Times> times_;         // of the newest few answers
  Clock::time_point newest_passed_{};
  Clock::time_point newest_answered_{};
};

}  // namespace sprout
