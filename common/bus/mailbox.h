#ifndef SPROUT_COMMON_BUS_MAILBOX_H_
#define SPROUT_COMMON_BUS_MAILBOX_H_

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

namespace sprout {

/// Hands the newest value from one thread to another. A value that was not taken when the next one
/// comes is replaced, and its sender is told. Thread-safe.
template <typename T>
class Mailbox {
 public:
  /// @returns true when an untaken value was replaced.
  bool Put(T value) {
    bool replaced = false;
    {
      const std::lock_guard lock(mutex_);
      replaced = value_.has_value();
      value_ = std::move(value);
    }
    filled_.notify_one();
    return replaced;
  }

  /// Waits for a value; nothing once `stop` is requested, even when there is one: who is slower
  /// than the sender always finds one.
  std::optional<T> Take(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, stop, [this] { return value_.has_value(); });
    if (stop.stop_requested()) return std::nullopt;
    return std::exchange(value_, std::nullopt);
  }

  /// As Take(), but nothing, too, when none came in time.
  std::optional<T> TakeWithin(std::chrono::milliseconds time, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    filled_.wait_for(lock, stop, time, [this] { return value_.has_value(); });
    if (stop.stop_requested()) return std::nullopt;
    return std::exchange(value_, std::nullopt);
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any filled_;
  std::optional<T> value_;
};

}  // namespace sprout

#endif  // SPROUT_COMMON_BUS_MAILBOX_H_
