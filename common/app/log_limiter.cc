#include "common/app/log_limiter.h"

#include <utility>

namespace sprout {

std::optional<int64_t> LogLimiter::Pass(std::chrono::steady_clock::time_point now) {
  if (now < next_) {
    ++held_back_;
    return std::nullopt;
  }
  next_ = now + std::chrono::seconds(1);
  return std::exchange(held_back_, 0);
}

bool LogLimiter::Log(LogLevel level, const std::string& text,
                     std::chrono::steady_clock::time_point now) {
  const std::optional<int64_t> held_back = Pass(now);
  if (held_back) LogLine(level, text + MoreText(*held_back));
  return held_back.has_value();
}

std::string MoreText(int64_t held_back) {
  return held_back == 0 ? "" : " (" + std::to_string(held_back) + " more since the last such line)";
}

void LimitedWarnings::Warn(const std::string& text) {
  const std::lock_guard lock(mutex_);
  limiter_.Log(LogLevel::kWarning, text, std::chrono::steady_clock::now());
}

}  // namespace sprout
