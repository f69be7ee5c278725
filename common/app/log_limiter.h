#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

namespace sprout {

/// Passes one log line a second and counts the others. Not thread-safe.
class LogLimiter {
 public:
  /// @returns how many lines were suppressed since the last one; nothing when this one is
  ///          suppressed, too.
  std::optional<int64_t> Pass(std::chrono::steady_clock::time_point now);

 private:
  std::chrono::steady_clock::time_point next_{};
  int64_t held_back_ = 0;
};

/// " (3 more since the last such line)", empty for none.
std::string MoreText(int64_t held_back);

/// Warnings of one kind, at most one a second. Thread-safe.
class LimitedWarnings {
 public:
  void Warn(const std::string& text);

 private:
  std::mutex mutex_;
  LogLimiter limiter_;
};

}  // namespace sprout
