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

bool EventQueue::Put(QueuedEvent event) {
  const size_t memory = event.event.memory();
  const std::lock_guard lock(mutex_);
  if (bytes_ + memory > max_bytes_) {
    if (event.kind != QueuedEvent::Kind::kTrigger) return false;
    if (!events_.empty() && events_.back().kind == QueuedEvent::Kind::kTrigger) {
      bytes_ -= events_.back().event.memory();
      events_.pop_back();
    }
  }
  bytes_ += memory;
  events_.push_back(std::move(event));
  changed_.notify_one();
  return true;
}

std::optional<QueuedEvent> EventQueue::TakeWithin(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, time, [this] { return closed_ || !events_.empty(); });
  if (events_.empty()) return std::nullopt;
  QueuedEvent event = std::move(events_.front());
  events_.pop_front();
  bytes_ -= event.event.memory();
  return event;
}

void EventQueue::Close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

bool EventQueue::IsFinished() const {
  const std::lock_guard lock(mutex_);
  return closed_ && events_.empty();
}

size_t EventQueue::size() const {
  const std::lock_guard lock(mutex_);
  return events_.size();
}

size_t EventQueue::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

}  // namespace sprout::record
