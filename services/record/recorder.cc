#include "services/record/recorder.h"

#include <algorithm>
#include <utility>

namespace sprout::record {

Recorder::Recorder(const std::optional<RingOptions>& ring, LogFolder& folder) : folder_(folder) {
  if (!ring) return;
  after_ = ring->after;
  ring_.emplace(ring->length, ring->max_bytes);
}

void Recorder::Add(RecordedEvent event) {
  if (!ring_) return folder_.Write(event);
  if (until_ && event.arrived > *until_) {
    until_.reset();
    folder_.Close();
  }
  if (until_) folder_.Write(event);
  ring_->Add(std::move(event));
}

void Recorder::AddStatus(RecordedEvent event) {
  if (ring_ || folder_.is_open()) Add(std::move(event));
}

bool Recorder::Trigger(Time now) {
  if (!ring_) return false;
  const bool begins = !until_ || now > *until_;
  if (begins) {
    folder_.Close();  // of a trigger before, when no message came since its end
    ring_->Forget(now);
    for (const RecordedEvent& event : ring_->events()) folder_.Write(event);
  }
  until_ = begins ? now + after_ : std::max(*until_, now + after_);
  return begins;
}

}  // namespace sprout::record
