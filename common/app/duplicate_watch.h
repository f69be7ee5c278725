#ifndef SPROUT_COMMON_APP_DUPLICATE_WATCH_H_
#define SPROUT_COMMON_APP_DUPLICATE_WATCH_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "common/app/stage_monitor.h"

namespace sprout {

/// Warns of other processes of the same stage on the same channels, once each; the warning is over
/// when the other one has ended, or has been silent for kSilentFor. Not thread-safe.
class DuplicateWatch {
 public:
  using Clock = std::chrono::steady_clock;

  /// Statuses come once a second.
  static constexpr std::chrono::seconds kSilentFor{5};

  /// @param monitor  knows the name of this process, and gets the warnings.
  /// @param now      returns the time; tests replace it.
  explicit DuplicateWatch(StageMonitor& monitor,
                          std::function<Clock::time_point()> now = Clock::now)
      : monitor_(monitor), now_(std::move(now)) {}

  /// A status of any process came, also of this one.
  void Heard(const StageStatus& status);

 private:
  struct Twin {
    std::string warning;
    Clock::time_point heard;
  };

  void ForgetSilentOnes();

  StageMonitor& monitor_;
  std::function<Clock::time_point()> now_;
  std::map<std::pair<std::string, int32_t>, Twin> twins_;  // by host and process
};

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_DUPLICATE_WATCH_H_
