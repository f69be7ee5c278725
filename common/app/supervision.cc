#include "common/app/supervision.h"

#include <fmt/core.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "common/core/number_text.h"

namespace sprout {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kMinLimit(1000);
constexpr milliseconds kStep(250);
constexpr int kTimesSlowest = 4;

std::string_view FromEnvironment(const char* name) {
  const char* const text = std::getenv(name);
  return text != nullptr ? text : "";
}

// Sends a state as sd_notify(3) says: a datagram to the socket that the service manager names,
// which is a path or, behind an @, a name of the kernel's. Does nothing if no socket is named.
void Tell(const std::string& state) {
  const std::string_view name = FromEnvironment("NOTIFY_SOCKET");
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  if (!(name.starts_with('/') || name.starts_with('@')) || name.size() >= sizeof address.sun_path) {
    return;
  }
  std::ranges::copy(name, address.sun_path);
  if (name[0] == '@') address.sun_path[0] = '\0';
  const int to = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (to < 0) return;
  sendto(to, state.data(), state.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address),
         static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size()));
  close(to);
}

// Zero when nobody watches this process (sd_watchdog_enabled(3)).
HangLimit::Duration WatchdogTime() {
  const std::string_view of = FromEnvironment("WATCHDOG_PID");
  if (!of.empty() && of != std::to_string(getpid())) return HangLimit::Duration(0);
  const auto time_us = ParseNumber<int64_t>(FromEnvironment("WATCHDOG_USEC"));
  return HangLimit::Duration(std::max<int64_t>(time_us.value_or(0), 0));
}

}  // namespace

void NotifyReady() { Tell("READY=1"); }

void NotifyStatus(const StageStatus& status) {
  Tell(fmt::format(
      "STATUS={} frames, {:.1f} a second, {} skipped, {} failed, {} incomplete, {} bad messages",
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
  return std::min(most_, std::max<Duration>(kMinLimit, in_steps));
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
