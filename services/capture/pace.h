#ifndef SPROUT_SERVICES_CAPTURE_PACE_H_
#define SPROUT_SERVICES_CAPTURE_PACE_H_

#include <chrono>
#include <cstdint>
#include <optional>

#include "common/core/frame_id.h"

namespace sprout::capture {

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

  // Between frames at a rate above 0.
  std::optional<Clock::duration> Period() const;

  std::optional<double> rate_hz_;  // nothing: as recorded
  Clock::time_point due_{};  // of the next frame at a fixed rate, of the newest one as recorded
  std::optional<int64_t> utime_;  // of the newest frame
};

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_PACE_H_
