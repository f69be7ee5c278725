#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "common/logfile/event_format.h"
#include "common/logfile/file_window.h"

namespace sprout {

/// An event and its position.
struct EventPosition {
  int64_t offset = 0;
  EventHeader header;

  int64_t end() const { return offset + header.event_bytes(); }
};

/// Whether the number of `place` continues that of an earlier event `before` (nothing: the start of
/// the file): at most as many numbers are missing as events would fit between the two.
bool IsInSequence(const std::optional<EventPosition>& before, const EventPosition& place);

/// Decides which bytes of a log are events. A log has no checksums, so a header is accepted or not
/// by its surroundings:
///
/// * its sync word is there, its lengths are possible and fit the file, its channel is readable;
/// * it is *followed*: at its end is the end of the file, a sync word, or an event of which only
/// the sync word is damaged; or it is *in sequence*: its number continues that of the event before
/// (logs number their events);
/// * it is not *contradicted*: the events expected next by its number do not begin inside it, and
/// the very next one does not begin after a gap.
///
/// So of two neighbours the damaged one is dropped, a wrong length swallows no good event, and sync
/// words or whole logs inside a payload do no harm. Damage to a number, a time or a payload cannot
/// be detected here.
///
/// Where headers contradict each other, the surroundings are searched; a hostile file can consist
/// of nothing else. So all searches together have a budget, proportional to the file and far above
/// what damage needs. When it is used up, an event is accepted only if the next one follows it, and
/// the whole file is read in O(bytes).
class EventFinder {
 public:
  /// @param events  window that the events are read through; must outlive this.
  EventFinder(const InputFile& file, FileWindow& events);

  /// The event that begins at `offset`; nothing when none is accepted there.
  /// @param before  the last event before it whose number can be trusted; nothing: none yet.
  std::optional<EventPosition> EventAt(int64_t offset, const std::optional<EventPosition>& before);

  /// The first event after damage at `offset`. One out of sequence is accepted only if none in
  /// sequence follows within 64 MB.
  std::optional<EventPosition> EventAfter(int64_t offset,
                                          const std::optional<EventPosition>& before);

  /// Whether the file ends inside an event that begins at or after `offset`.
  bool IsTorn(int64_t offset);

 private:
  std::span<const uint8_t> Peek(int64_t offset, int64_t count);
  std::optional<EventPosition> PositionAt(int64_t offset);
  std::optional<EventPosition> PositionButForSync(int64_t offset);
  bool IsFollowed(const EventPosition& place);
  bool IsContradicted(const EventPosition& place, const std::optional<EventPosition>& before,
                      bool followed);
  bool HoldsOthers(const EventPosition& place, const std::optional<EventPosition>& before,
                   bool followed);
  bool EndsEarly(const EventPosition& place);
  std::optional<int64_t> FindSync(int64_t from, int64_t limit);
  bool IsOutOfBudget() const { return budget_ <= 0; }

  const InputFile& file_;
  FileWindow& events_;
  FileWindow search_;
  FileWindow peek_;
  int64_t budget_;  // bytes that may still be searched
};

}  // namespace sprout
