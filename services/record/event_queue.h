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

/// An entry that waits to be written.
struct QueuedEvent {
  enum class Kind {
    kMessage,    ///< to be recorded
    kOwnStatus,  ///< to be recorded, but does not begin a log
    kLookAt,     ///< not to be recorded; may be a trigger
    kTrigger,    ///< no message: a trigger from outside
  };
  Kind kind = Kind::kMessage;
  RecordedEvent event;
  std::string trigger = {};  ///< of kTrigger: its source
};

/// Queue between the thread that receives messages and the one that writes to the disk.
/// Thread-safe.
class EventQueue {
 public:
  /// @param max_bytes  most memory of waiting entries.
  explicit EventQueue(size_t max_bytes) : max_bytes_(max_bytes) {}

  /// @returns false when it does not fit; a trigger always does.
  [[nodiscard]] bool Put(QueuedEvent event);

  /// Waits for the oldest one; nothing when none came in time, or when the queue is closed and
  /// empty.
  std::optional<QueuedEvent> TakeWithin(std::chrono::milliseconds time);

  /// No more entries follow: TakeWithin() does not wait any more.
  void Close();

  /// Closed and empty.
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
