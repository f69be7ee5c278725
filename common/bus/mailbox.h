#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

namespace sprout {

/// Hands the newest value from one thread to another. A new value replaces one that was not yet
/// taken, and its sender learns of it. Thread-safe.
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

  /// Waits for a value. Once `stop` is requested it returns nothing, even if there is a value: a
  /// taker slower than the sender would always find one.
  std::optional<T> Take(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, stop, [this] { return value_.has_value(); });
    if (stop.stop_requested()) return std::nullopt;
    return std::exchange(value_, std::nullopt);
  }

  /// Waits for a value as Take() does, but returns nothing if none came in time.
  std::optional<T> TakeWithin(std::chrono::milliseconds time, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    filled_.wait_for(lock, stop, time, [this] { return value_.has_value(); });
    if (stop.stop_requested()) return std::nullopt;
    return std::exchange(value_, std::nullopt);
  }

  /// @returns whether there was an untaken value, which is dropped.
  bool Clear() {
    const std::lock_guard lock(mutex_);
    return std::exchange(value_, std::nullopt).has_value();
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any filled_;
  std::optional<T> value_;
};

}  // namespace sprout
