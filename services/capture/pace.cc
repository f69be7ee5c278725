#include "services/capture/pace.h"

#include <algorithm>

namespace sprout {

void Pace::Start(Clock::time_point now) { due_ = now; }

Pace::Clock::time_point Pace::DueBeforeTaking(int64_t sent) const {
  if (!rate_hz_ || *rate_hz_ <= 0) return due_;
  const std::chrono::duration<double> after(static_cast<double>(sent) / *rate_hz_);
  return due_ + std::chrono::duration_cast<Clock::duration>(after);
}

Pace::Clock::time_point Pace::DueBeforeSending(const FrameId& id) {
  if (rate_hz_) return due_;
  // Neither utime is negative, so no difference overflows.
  const std::chrono::microseconds interval(id.utime - utime_.value_or(id.utime));
  due_ += std::clamp<std::chrono::microseconds>(interval, std::chrono::microseconds::zero(),
                                                kLongestInterval);
  utime_ = id.utime;
  return due_;
}

}  // namespace sprout
