#include "common/app/log_limiter.h"

#include <utility>

#include "common/app/log.h"

namespace sprout {

std::optional<int64_t> LogLimiter::Pass(std::chrono::steady_clock::time_point now) {
  if (now < next_) {
    ++held_back_;
    return std::nullopt;
  }
  next_ = now + std::chrono::seconds(1);
  return std::exchange(held_back_, 0);
}

std::string MoreText(int64_t held_back) {
  return held_back == 0 ? "" : " (" + std::to_string(held_back) + " more since the last such line)";
}

void LimitedWarnings::Warn(const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (const auto held_back = limiter_.Pass(std::chrono::steady_clock::now())) {
    LogLine(LogLevel::kWarning, "{}{}", text, MoreText(*held_back));
  }
}

}  // namespace sprout
