#ifndef SPROUT_SERVICES_RECORD_RECORDED_EVENT_H_
#define SPROUT_SERVICES_RECORD_RECORDED_EVENT_H_

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace sprout::record {

/// A message as it came.
struct RecordedEvent {
  using Clock = std::chrono::steady_clock;

  int64_t utime = 0;               ///< µs since 1970-01-01 UTC, when it came; goes into the log
  Clock::time_point arrived = {};  ///< the same by a clock that nobody sets
  std::string channel;             ///< with prefix
  std::vector<uint8_t> data;

  /// Memory that it takes, bytes.
  size_t memory() const { return sizeof *this + channel.size() + data.size(); }
};

}  // namespace sprout::record

#endif  // SPROUT_SERVICES_RECORD_RECORDED_EVENT_H_
