#ifndef SPROUT_SERVICES_RECORD_RECORDED_EVENT_H_
#define SPROUT_SERVICES_RECORD_RECORDED_EVENT_H_

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace sprout::record {

/// A received message.
struct RecordedEvent {
  using Clock = std::chrono::steady_clock;

  int64_t utime = 0;               ///< arrival, µs since 1970-01-01 UTC; written into the log
  Clock::time_point arrived = {};  ///< arrival by a monotonic clock
  std::string channel;             ///< with prefix
  std::vector<uint8_t> data;

  /// Memory that it takes, bytes.
  size_t memory() const { return sizeof *this + channel.size() + data.size(); }
};

}  // namespace sprout::record

#endif  // SPROUT_SERVICES_RECORD_RECORDED_EVENT_H_
