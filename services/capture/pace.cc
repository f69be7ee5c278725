#include "services/capture/pace.h"

#include <algorithm>

namespace sprout::capture {
namespace {

// Between frames at the lowest rates: 30 years, which a clock can still count.
constexpr double kLongestPeriodS = 1e9;

// The time that the next frame's due time counts from, when a frame was due at `due` and comes
// `now`.
Pace::Clock::time_point Forgiving(Pace::Clock::time_point due, Pace::Clock::time_point now,
                                  Pace::Clock::duration interval) {
  return now - due > interval ? now : due;
}

}  // namespace

void Pace::Start(Clock::time_point now) { due_ = now; }

Pace::Clock::time_point Pace::DueBeforeTaking() const { return due_; }

std::optional<Pace::Clock::duration> Pace::Period() const {
  if (!rate_hz_ || *rate_hz_ <= 0) return std::nullopt;
  const std::chrono::duration<double> exact(std::min(1 / *rate_hz_, kLongestPeriodS));
  return std::chrono::duration_cast<Clock::duration>(exact);
}

bool Pace::IsLate(Clock::time_point now) const {
  const std::optional<Clock::duration> period = Period();
  return period && now - due_ > *period;
}

void Pace::Take(Clock::time_point now) {
  const std::optional<Clock::duration> period = Period();
  if (period) due_ = Forgiving(due_, now, *period) + *period;
}

Pace::Clock::time_point Pace::DueBeforeSending(const FrameId& id, Clock::time_point now) {
  if (rate_hz_) return now;
  // Neither utime is negative, so no difference overflows.
  const std::chrono::microseconds interval(id.utime - utime_.value_or(id.utime));
  const auto waited = std::clamp<std::chrono::microseconds>(
      interval, std::chrono::microseconds::zero(), kLongestInterval);
  utime_ = id.utime;
  due_ = Forgiving(due_ + waited, now, waited);
  return due_;
}

}  // namespace sprout::capture
