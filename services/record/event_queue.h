#ifndef SPROUT_SERVICES_RECORD_EVENT_QUEUE_H_
#define SPROUT_SERVICES_RECORD_EVENT_QUEUE_H_

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include "services/record/recorded_event.h"

namespace sprout::record {

/// What waits to be written.
struct QueuedEvent {
  enum class Kind {
    kMessage,    ///< to be recorded
    kOwnStatus,  ///< to be recorded, but no reason to begin a log
    kLookAt,     ///< not to be recorded; it may be a trigger
    kTrigger,    ///< no message: somebody wants what is in the ring
  };
  Kind kind = Kind::kMessage;
  RecordedEvent event;
  std::string trigger = {};  ///< of kTrigger: who wants it
};

/// Between the thread that takes messages from the network and the one that waits for the disk.
/// Thread-safe.
class EventQueue {
 public:
  /// @param max_bytes  memory that what waits may take.
  explicit EventQueue(size_t max_bytes) : max_bytes_(max_bytes) {}

  /// @returns false when it does not fit; a trigger always does.
  [[nodiscard]] bool Put(QueuedEvent event);

  /// Waits for the oldest one; nothing when none came in time, or when the queue is closed and
  /// empty.
  std::optional<QueuedEvent> TakeWithin(std::chrono::milliseconds time);

  /// Nothing will be put any more: TakeWithin() does not wait.
  void Close();

  /// Closed, and everything was taken.
  bool IsFinished() const;

  size_t size() const;
  size_t bytes() const;

 private:
  size_t max_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<QueuedEvent> events_;
  size_t bytes_ = 0;
  bool closed_ = false;
};

}  // namespace sprout::record

#endif  // SPROUT_SERVICES_RECORD_EVENT_QUEUE_H_
