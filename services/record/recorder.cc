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
  if (!ring_) {
    ++unwritten_;
    return Write(event);
  }
  if (until_ && event.arrived <= *until_) {
    ++unwritten_;
    WriteMissing();  // a trigger and messages may change places by µs
    Write(event);
    ring_->Add(std::move(event));
  } else {
    ring_->Add(std::move(event));
    ++missing_;
    CloseIfApart();
  }
}

void Recorder::AddStatus(RecordedEvent event) {
  if (ring_ || folder_.is_open()) Add(std::move(event));
}

bool Recorder::Trigger(Time now) {
  if (!ring_) return false;
  ring_->Forget(now);
  if (until_ && now > *until_) CloseIfApart();
  const bool begins = !until_;
  if (begins) missing_ = ring_->events().size();
  WriteMissing();
  until_ = begins ? now + after_ : std::max(*until_, now + after_);
  return begins;
}

// Of an event that is counted as unwritten.
void Recorder::Write(const RecordedEvent& event) {
  folder_.Write(event);
  --unwritten_;
}

void Recorder::WriteMissing() {
  const auto& events = ring_->events();
  unwritten_ += static_cast<int64_t>(missing_);
  for (; missing_ > 0; --missing_) Write(events[events.size() - missing_]);
}

void Recorder::CloseIfApart() {
  if (!until_ || missing_ < ring_->events().size()) return;
  until_.reset();
  folder_.Close();
}

}  // namespace sprout::record
