#include "common/app/supervision.h"

#include <fmt/core.h>
#include <sys/stat.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace sprout {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLeast(1000);
constexpr milliseconds kStep(250);
constexpr int kTimesSlowest = 4;

void Tell(const std::string& state) { sd_notify(/*unset_environment=*/0, state.c_str()); }

// Zero when nobody watches this process.
HangLimit::Duration WatchdogTime() {
  uint64_t time_us = 0;
  const int on = sd_watchdog_enabled(/*unset_environment=*/0, &time_us);
  return HangLimit::Duration(on > 0 ? static_cast<int64_t>(time_us) : 0);
}

}  // namespace

void NotifyReady() { Tell("READY=1"); }

void NotifyStatus(const StageStatus& status) {
  Tell(
      fmt::format("STATUS={} frames, {:.1f} a second, {} skipped, {} failed, {} incomplete, {} bad "
                  "messages",
                  status.frames_out, status.rate_hz, status.frames_skipped, status.frames_failed,
                  status.frames_incomplete, status.bad_messages));
}

bool LogsToJournal() {
  const char* const stream = std::getenv("JOURNAL_STREAM");  // device:inode of what systemd gave
  struct stat file {};
  return stream != nullptr && fstat(STDERR_FILENO, &file) == 0 &&
         fmt::format("{}:{}", file.st_dev, file.st_ino) == stream;
}

void HangLimit::Add(Duration frame) {
  frames_.push_back(frame);
  if (frames_.size() > kFramesToRemember) frames_.pop_front();
}

HangLimit::Duration HangLimit::limit() const {
  if (frames_.size() < kFramesToTrust) return most_;
  const Duration wanted = kTimesSlowest * *std::ranges::max_element(frames_);
  const Duration in_steps = (wanted + kStep - Duration(1)) / kStep * kStep;
  return std::min(most_, std::max<Duration>(kLeast, in_steps));
}

Watchdog::Watchdog() : limit_(WatchdogTime()), told_(limit_.limit()), alive_(Clock::now()) {
  is_on_ = told_.count() > 0;
}

void Watchdog::Idle() {
  alive_ = Clock::now();
  if (!is_on_ || alive_ < told_at_ + kIdlePeriod / 2) return;
  Tell("WATCHDOG=1");
  told_at_ = alive_;
}

void Watchdog::FrameDone() {
  const Clock::time_point now = Clock::now();
  limit_.Add(std::chrono::duration_cast<HangLimit::Duration>(now - alive_));
  alive_ = now;
  if (!is_on_) return;
  const HangLimit::Duration limit = limit_.limit();
  if (limit != told_) Tell("WATCHDOG_USEC=" + std::to_string(limit.count()));
  told_ = limit;
  Tell("WATCHDOG=1");
  told_at_ = now;
}

}  // namespace sprout
