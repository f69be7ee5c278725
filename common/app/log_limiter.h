#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "common/app/log.h"

namespace sprout {

/// Passes one log line a second and counts the others. Not thread-safe.
class LogLimiter {
 public:
  /// @returns how many lines were suppressed since the last one; nothing when this one is
  ///          suppressed, too.
  std::optional<int64_t> Pass(std::chrono::steady_clock::time_point now);

  /// Writes a line that passes, with the number of suppressed ones. @returns whether it does.
  bool Log(LogLevel level, const std::string& text, std::chrono::steady_clock::time_point now);

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
