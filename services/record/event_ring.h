#ifndef SPROUT_SERVICES_RECORD_EVENT_RING_H_
#define SPROUT_SERVICES_RECORD_EVENT_RING_H_

#include <chrono>
#include <cstdint>
#include <deque>

#include "services/record/recorded_event.h"

namespace sprout::record {

/// The messages of the last seconds, in memory. Not thread-safe.
class EventRing {
 public:
  using Duration = RecordedEvent::Clock::duration;

  /// @param length     how far back it reaches from the newest message.
  /// @param max_bytes  most memory; beyond it the oldest messages are dropped early, and counted.
  EventRing(Duration length, size_t max_bytes) : length_(length), max_bytes_(max_bytes) {}

  /// @param event  not older than the one before.
  void Add(RecordedEvent event);

  /// Drops messages that are too old.
  void Forget(RecordedEvent::Clock::time_point now);

  /// Oldest first.
  const std::deque<RecordedEvent>& events() const { return events_; }

  /// Messages dropped early for lack of memory.
  int64_t not_fitted() const { return not_fitted_; }

 private:
  void DropOldest();

  Duration length_;
  size_t max_bytes_;
  std::deque<RecordedEvent> events_;
  size_t bytes_ = 0;
  int64_t not_fitted_ = 0;
};

}  // namespace sprout::record

#endif  // SPROUT_SERVICES_RECORD_EVENT_RING_H_
