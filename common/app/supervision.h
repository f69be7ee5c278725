#pragma once

#include <chrono>
#include <deque>
#include <string>

#include "common/core/stage_status.h"

namespace sprout {

/// Tells the service manager (systemd, Type=notify) that this process is ready for messages. Like
/// all of this file, does nothing without a service manager.
void NotifyReady();

/// Tells it the state of the process in one line, which `systemctl status` shows.
void NotifyStatus(const StageStatus& status);

/// Whether stderr goes to the system's journal.
bool LogsToJournal();

/// How long a worker may show no sign of life before it counts as hung: four times the slowest of
/// its newest 100 frames, at least 1 s, at most the given limit. During the first 10 frames it is
/// the given limit.
class HangLimit {
 public:
  using Duration = std::chrono::microseconds;

  static constexpr size_t kFramesToTrust = 10;
  static constexpr size_t kFramesToRemember = 100;

  explicit HangLimit(Duration most) : most_(most) {}

  /// Takes the time that a frame took.
  void Add(Duration frame);

  /// The limit, in steps of 0.25 s, so that it rarely changes.
  Duration limit() const;

 private:
  Duration most_;
  std::deque<Duration> frames_;
};

/// Tells the service manager that the worker loop is alive; without that it kills the process after
/// a while and starts it again (WatchdogSec). To be called by the worker thread: a separate thread
/// would report life while the work hangs.
///
/// A frame may take at most WatchdogSec. After some frames the limit becomes shorter (HangLimit),
/// so that a hung process of a fast stage is noticed in a second, and a slow stage is not killed.
/// After a restart it is WatchdogSec again.
class Watchdog {
 public:
  /// A worker without work must call Idle() at least this often.
  static constexpr std::chrono::milliseconds kIdlePeriod{200};

  Watchdog();

  /// The worker waits for work. May be called at any rate.
  void Idle();

  /// The worker has finished a frame; it took the time since the call before this one.
  void FrameDone();

 private:
  using Clock = std::chrono::steady_clock;

  bool is_on_;
  HangLimit limit_;
  HangLimit::Duration told_;
  Clock::time_point alive_;         // newest call
  Clock::time_point told_at_ = {};  // that the worker is alive
};

}  // namespace sprout
