#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
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

/// An entry that waits to be written.
struct QueuedEvent {
  enum class Kind {
    kMessage,      ///< to be recorded
    kOwnStatus,    ///< to be recorded, but does not begin a log
    kTriggerOnly,  ///< not to be recorded; may be a trigger
    kTrigger,      ///< no message: a trigger from outside
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

  /// @returns false when it does not fit. A trigger always does; in a full queue it replaces one
  ///          that no message has followed.
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
