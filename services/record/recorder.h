#ifndef SPROUT_SERVICES_RECORD_RECORDER_H_
#define SPROUT_SERVICES_RECORD_RECORDER_H_

#include <chrono>
#include <cstdint>
#include <optional>

#include "services/record/event_ring.h"
#include "services/record/log_folder.h"
#include "services/record/recorded_event.h"

namespace sprout::record {

struct RingOptions {
  RecordedEvent::Clock::duration length{};  ///< what is kept of the time before a trigger
  size_t max_bytes = 0;                     ///< memory for it
  RecordedEvent::Clock::duration after{};   ///< what is written of the time behind a trigger
};

/// Decides which messages go to the disk. Without a ring: every one. With a ring: nothing until a
/// trigger comes, then the ring and what follows, in one log. A trigger whose ring has a message of
/// the log before continues that log, so no message is written twice, however fast triggers come,
/// and a log has all messages from its first trigger's ring to its end. It stays open as long as
/// that may happen. Time is that of the messages, so a slow disk moves no border. Not thread-safe.
class Recorder {
 public:
  using Time = RecordedEvent::Clock::time_point;

  /// @param folder  must outlive this.
  Recorder(const std::optional<RingOptions>& ring, LogFolder& folder);

  /// @throws LogError, see LogFolder::Write().
  void Add(RecordedEvent event);

  /// Our own status: as Add(), but it begins no log.
  void AddStatus(RecordedEvent event);

  /// Somebody wants what is in the ring. Does nothing without a ring.
  /// @returns true when a log begins, false when one goes on. @throws LogError.
  bool Trigger(Time now);

  /// Ends the open log. @throws LogError.
  void Finish() { folder_.Close(); }

  /// nullptr: there is none.
  const EventRing* ring() const { return ring_ ? &*ring_ : nullptr; }

 private:
  void WriteMissing();
  void CloseIfApart();

  LogFolder& folder_;
  RecordedEvent::Clock::duration after_{};
  std::optional<EventRing> ring_;
  std::optional<Time> until_;  // what comes up to here goes into the open log; none: no open log
  size_t missing_ = 0;         // newest messages of the ring that are not in the open log
};

}  // namespace sprout::record

#endif  // SPROUT_SERVICES_RECORD_RECORDER_H_
