#ifndef SPROUT_SERVICES_VIEW_LOG_QUALITY_H_
#define SPROUT_SERVICES_VIEW_LOG_QUALITY_H_

#include <cstdint>
#include <stop_token>
#include <thread>
#include <vector>

#include "services/view/log_file.h"

namespace sprout::view {

/// The order in which frames are rated: at any time the rated ones are spread evenly, so that a
/// time line covers the whole log from the start and becomes finer. At most `most` of `count`
/// frames.
std::vector<int64_t> SpreadOrder(int64_t count, int64_t most);

/// Rates the frames of a log on its own thread, at low priority, once the log is read. In a long
/// log only a part of the frames, since each takes some hundredths of a second.
class LogQuality {
 public:
  static constexpr int64_t kMaxFrames = 2000;

  /// @param log  must outlive this.
  explicit LogQuality(LogFile& log);

 private:
  void Run(const std::stop_token& stop);

  LogFile& log_;
  std::jthread thread_;
};

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_LOG_QUALITY_H_
