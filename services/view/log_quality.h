#ifndef SPROUT_SERVICES_VIEW_LOG_QUALITY_H_
#define SPROUT_SERVICES_VIEW_LOG_QUALITY_H_

#include <cstdint>
#include <stop_token>
#include <thread>
#include <vector>

#include "services/view/log_file.h"

namespace sprout::view {

/// The order in which frames are rated: at any moment those that were are spread evenly, so that a
/// time line shows all of a log at once, and more and more of it. At most `most` of `count` frames.
std::vector<int64_t> SpreadOrder(int64_t count, int64_t most);

/// Rates the frames of a log on a thread of its own, at a low priority, once the log is read. Of a
/// long log a part of the frames: each takes some hundredths of a second.
class LogQuality {
 public:
  static constexpr int64_t kMostFrames = 2000;

  /// @param log  must outlive this.
  explicit LogQuality(LogFile& log);

 private:
  void Run(const std::stop_token& stop);

  LogFile& log_;
  std::jthread thread_;
};

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_LOG_QUALITY_H_
