#ifndef SPROUT_SERVICES_RECORD_RECORDER_H_
#define SPROUT_SERVICES_RECORD_RECORDER_H_

#include <optional>

#include "services/record/event_ring.h"
#include "services/record/log_folder.h"

namespace sprout::record {

struct RingOptions {
  RecordedEvent::Clock::duration length{};  ///< time kept before a trigger
  size_t max_bytes = 0;                     ///< memory for it
  RecordedEvent::Clock::duration after{};   ///< time recorded after a trigger
};

/// Decides which messages are written. Without a ring: every one. With a ring: nothing until a
/// trigger comes, then the ring and the following messages, in one log. If the ring of a later
/// trigger still contains a message of the previous log, that log is continued. So no message is
/// written twice, however fast triggers come, and a log has all messages from its first trigger's
/// ring to its end. A log stays open as long as it may be continued. Time is that of the messages,
/// so a slow disk does not change what is recorded. Not thread-safe.
class Recorder {
 public:
  using Time = RecordedEvent::Clock::time_point;

  /// @param folder  must outlive this.
  Recorder(const std::optional<RingOptions>& ring, LogFolder& folder);

  /// @throws LogError, see LogFolder::Write().
  void Add(RecordedEvent event);

  /// The recorder's own status: as Add(), but it does not begin a log.
  void AddStatus(RecordedEvent event);

  /// A trigger. Does nothing without a ring.
  /// @returns true when a log begins, false when one continues. @throws LogError.
  bool Trigger(Time now);

  /// Ends the open log. @throws LogError.
  void Finish() { folder_.Close(); }

  /// Messages that were to be written and were not: 0 until something above has thrown.
  int64_t unwritten() const { return unwritten_; }

  /// The ring; nullptr: there is none.
  const EventRing* ring() const { return ring_ ? &*ring_ : nullptr; }

 private:
  void Write(const RecordedEvent& event);
  void WriteMissing();
  void CloseIfApart();

  LogFolder& folder_;
  RecordedEvent::Clock::duration after_{};
  std::optional<EventRing> ring_;
  std::optional<Time> until_;  // end of the open log; none: no open log
  size_t missing_ = 0;         // newest messages of the ring that are not in the open log
  int64_t unwritten_ = 0;
};

}  // namespace sprout::record

#endif  // SPROUT_SERVICES_RECORD_RECORDER_H_
