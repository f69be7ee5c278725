#ifndef SPROUT_COMMON_APP_DUPLICATE_WATCH_H_
#define SPROUT_COMMON_APP_DUPLICATE_WATCH_H_

#include <cstdint>
#include <set>
#include <string>
#include <utility>

#include "common/app/stage_monitor.h"

namespace sprout {

/// Warns of other processes of the same stage on the same channels, once each. Not thread-safe.
class DuplicateWatch {
 public:
  /// @param monitor  knows the name of this process, and gets the warnings.
  explicit DuplicateWatch(StageMonitor& monitor) : monitor_(monitor) {}

  /// A status of any process came.
  void Heard(const StageStatus& status);

 private:
  StageMonitor& monitor_;
  std::set<std::pair<std::string, int32_t>> told_;  // host and process
};

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_DUPLICATE_WATCH_H_
