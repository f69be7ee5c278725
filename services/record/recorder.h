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
/// trigger comes, then the ring and what follows, in one log; a trigger meanwhile prolongs it. The
/// ring is filled meanwhile, too, so every log begins as far before its trigger as the ring
/// reaches, even where that is in the log before as well. Time is that of the messages, so a
/// slow disk moves no border. Not thread-safe.
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
  LogFolder& folder_;
  RecordedEvent::Clock::duration after_{};
  std::optional<EventRing> ring_;
  std::optional<Time> until_;  // a log of the ring is being written
};

}  // namespace sprout::record

#endif  // SPROUT_SERVICES_RECORD_RECORDER_H_
