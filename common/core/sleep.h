#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stop_token>

namespace sprout {

/// Sleeps until a time, or until a stop is requested. @returns false when a stop was requested.
template <typename Clock, typename Duration>
bool SleepUntil(std::chrono::time_point<Clock, Duration> time, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_until(lock, stop, time, [] { return false; });
  return !stop.stop_requested();
}

/// Sleeps for a duration, see SleepUntil().
template <typename Rep, typename Period>
bool SleepFor(std::chrono::duration<Rep, Period> time, const std::stop_token& stop) {
  using Clock = std::chrono::steady_clock;
  return SleepUntil(Clock::now() + std::chrono::duration_cast<Clock::duration>(time), stop);
}

}  // namespace sprout
