#ifndef SPROUT_COMMON_APP_SUPERVISION_H_
#define SPROUT_COMMON_APP_SUPERVISION_H_

#include <chrono>
#include <deque>
#include <string>

#include "common/core/stage_status.h"

namespace sprout {

/// Tells the service manager (systemd, Type=notify) that this process is ready for messages. Does
/// nothing without one, as the rest of this file.
void TellReady();

/// Tells it in a line how the process fares; `systemctl status` shows it.
void TellStatus(const StageStatus& status);

/// Whether stderr goes to the system's journal.
bool LogsToJournal();

/// After how long a worker that shows no life counts as hung: four times its slowest frame of the
/// newest 100, but at least 1 s, and at most what it is created with. A worker of which fewer than
/// 10 frames are known has all of that.
class HangLimit {
 public:
  using Duration = std::chrono::microseconds;

  static constexpr size_t kFramesToTrust = 10;
  static constexpr size_t kFramesToRemember = 100;

  explicit HangLimit(Duration most) : most_(most) {}

  /// A frame took so long.
  void Add(Duration frame);

  /// In steps of 0.25 s, so that it seldom changes.
  Duration limit() const;

 private:
  Duration most_;
  std::deque<Duration> frames_;
};

/// Tells the service manager that the worker loop is alive; when it hears nothing for a while, it
/// kills the process and starts it again (WatchdogSec). For the thread that does the work: a
/// thread of its own would say that all is well while the work hangs.
///
/// WatchdogSec is the most that a frame may take. When it is known how long frames take here, the
/// time allowed becomes shorter (HangLimit), so that a hung process of a fast stage is noticed in a
/// second, and a slow stage is left in peace. After a start it is WatchdogSec again.
class Watchdog {
 public:
  /// How often a worker without work has to call Idle(), at least.
  static constexpr std::chrono::milliseconds kIdlePeriod{200};

  Watchdog();

  /// The worker waits for work. May be called as often as one likes.
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

#endif  // SPROUT_COMMON_APP_SUPERVISION_H_
