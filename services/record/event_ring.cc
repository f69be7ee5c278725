#include "services/record/event_ring.h"

#include <utility>

namespace sprout::record {

void EventRing::Add(RecordedEvent event) {
  Forget(event.arrived);
  bytes_ += event.memory();
  events_.push_back(std::move(event));
  while (bytes_ > max_bytes_) {
    DropOldest();
    ++not_fitted_;
  }
}

void EventRing::Forget(RecordedEvent::Clock::time_point now) {
  while (!events_.empty() && now - events_.front().arrived > length_) DropOldest();
}

void EventRing::DropOldest() {
  bytes_ -= events_.front().memory();
  events_.pop_front();
}

}  // namespace sprout::record
