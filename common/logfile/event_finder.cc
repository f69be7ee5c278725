#include "common/logfile/event_finder.h"

#include <algorithm>
#include <cstring>

namespace sprout {
namespace {

constexpr int64_t kSearchBytes = int64_t{1} << 20;
constexpr int64_t kPeekBytes = 256;
constexpr int64_t kMaxLookAhead = int64_t{64} << 20;
constexpr int64_t kNumberEnd = 12;  // bytes up to the end of the number

// What all searches in a file may cost, in bytes that are read: a few seconds, and so many times
// the file.
constexpr int64_t kBudgetBytes = int64_t{2} << 30;
constexpr int64_t kBudgetPerByte = 16;
// What a sync word costs that is looked at, in the time of bytes that are searched.
constexpr int64_t kLookBytes = 128;

// How far `number` is behind `before`; numbers may be damaged, so without signed overflow.
uint64_t Distance(int64_t before, int64_t number) {
  return static_cast<uint64_t>(number) - static_cast<uint64_t>(before);
}

// Whether `other` has a number that goes on from that of `place` when the length of `place` is not
// believed.
bool GoesOn(const EventPosition& place, const EventPosition& other) {
  const uint64_t distance = Distance(place.header.number, other.header.number);
  const int64_t bytes = other.offset - place.offset;
  return distance >= 1 && distance <= 1 + static_cast<uint64_t>(bytes / kMinEventBytes);
}

}  // namespace

bool IsInSequence(const std::optional<EventPosition>& before, const EventPosition& place) {
  const uint64_t distance = Distance(before ? before->header.number : -1, place.header.number);
  const int64_t bytes = place.offset - (before ? before->end() : 0);
  if (bytes <= 0) return distance == 1;
  // One more than fits: damage to a length makes an event end up to one event too late.
  return distance >= 1 && distance <= 2 + static_cast<uint64_t>(bytes / kMinEventBytes);
}

EventFinder::EventFinder(const InputFile& file, FileWindow& events)
    : file_(file),
      events_(events),
      search_(file, kSearchBytes),
      peek_(file, kPeekBytes),
      budget_(kBudgetBytes + kBudgetPerByte * file.size()) {}

std::span<const uint8_t> EventFinder::Peek(int64_t offset, int64_t count) {
  return (events_.Holds(offset, count) ? events_ : peek_).View(offset, count);
}

std::optional<EventPosition> EventFinder::PositionButForSync(int64_t offset) {
  const auto bytes = Peek(offset, kMaxHeadBytes);
  const auto header = DecodeHeader(bytes);
  if (!header || !IsPlausible(*header, bytes)) return std::nullopt;
  if (header->event_bytes() > file_.size() - offset) return std::nullopt;
  return EventPosition{offset, *header};
}

std::optional<EventPosition> EventFinder::PositionAt(int64_t offset) {
  if (offset >= file_.size() || !BeginsWithSync(Peek(offset, kMaxHeadBytes))) return std::nullopt;
  return PositionButForSync(offset);
}

bool EventFinder::IsFollowed(const EventPosition& place) {
  // True at the end of the file as well.
  if (BeginsWithSync(Peek(place.end(), kNumberEnd))) return true;
  const auto behind = PositionButForSync(place.end());
  return behind && BeginsWithSync(Peek(behind->end(), kNumberEnd));
}

// An event of the sequence that begins inside of `place` speaks against its length. When the place
// is followed and what follows does not claim that there are some inside, they may as well be those
// of a log in its payload; then the first one decides: numbers of its own, so a log.
bool EventFinder::HoldsOthers(const EventPosition& place,
                              const std::optional<EventPosition>& before, bool followed) {
  const auto next = PositionAt(place.end());
  const bool may_hold_log = followed && !(next && GoesOn(place, *next));
  const bool numbered_wrong = !IsInSequence(before, place);
  int64_t from = place.offset + 1;
  // A sync word that begins inside may end behind it.
  while (const auto sync = FindSync(from, std::min(file_.size(), place.end() + 3))) {
    from = *sync + 1;
    const auto other = PositionAt(*sync);
    if (!other) continue;
    if (GoesOn(place, *other) || (numbered_wrong && IsInSequence(before, *other))) return true;
    if (may_hold_log) return false;
    if (IsOutOfBudget() || (!followed && IsFollowed(*other))) return true;
  }
  return false;
}

// The very next event begins further behind: the length is too small. A later one says that the
// next one, and not this one, is damaged.
bool EventFinder::EndsEarly(const EventPosition& place) {
  int64_t from = place.end();
  const int64_t limit = std::min(file_.size(), from + kMaxLookAhead);
  while (const auto sync = FindSync(from, limit)) {
    from = *sync + 1;
    if (IsOutOfBudget()) return true;
    const auto other = DecodeHeader(Peek(*sync, kHeaderBytes));
    if (!other || !GoesOn(place, {*sync, *other})) continue;
    return Distance(place.header.number, other->number) == 1;
  }
  return false;
}

bool EventFinder::IsContradicted(const EventPosition& place,
                                 const std::optional<EventPosition>& before, bool followed) {
  const auto next = DecodeHeader(Peek(place.end(), kHeaderBytes));
  if (next && Distance(place.header.number, next->number) == 1) return false;  // nearly always
  if (IsOutOfBudget()) return true;                                            // no evidence
  return HoldsOthers(place, before, followed) || (!followed && EndsEarly(place)) || IsOutOfBudget();
}

std::optional<EventPosition> EventFinder::EventAt(int64_t offset,
                                                  const std::optional<EventPosition>& before) {
  const auto place = PositionAt(offset);
  if (!place) return std::nullopt;
  const bool followed = IsFollowed(*place);
  if (!followed && !IsInSequence(before, *place)) return std::nullopt;
  if (IsContradicted(*place, before, followed)) return std::nullopt;
  return place;
}

std::optional<EventPosition> EventFinder::EventAfter(int64_t offset,
                                                     const std::optional<EventPosition>& before) {
  // An event whose sync word alone is damaged is skipped whole: what its payload holds is none.
  const auto damaged = PositionButForSync(offset);
  const bool whole = damaged && !BeginsWithSync(Peek(offset, kNumberEnd)) && IsFollowed(*damaged) &&
                     !IsContradicted(*damaged, before, /*followed=*/true);
  std::optional<EventPosition> out_of_sequence;
  int64_t from = whole ? damaged->end() : offset + 1;
  int64_t limit = file_.size();
  while (const auto sync = FindSync(from, limit)) {
    from = *sync + 1;
    const auto place = EventAt(*sync, before);
    if (!place) continue;
    if (IsInSequence(before, *place)) return place;
    if (!out_of_sequence) out_of_sequence = place;
    if (IsOutOfBudget()) break;
    limit = std::min(limit, out_of_sequence->offset + kMaxLookAhead);
  }
  return out_of_sequence;
}

bool EventFinder::IsTorn(int64_t offset) {
  const auto is_cut = [this](int64_t at) {
    const auto bytes = Peek(at, kMaxHeadBytes);
    const auto header = DecodeHeader(bytes);
    if (!header) return true;
    return IsPlausible(*header, bytes) && header->event_bytes() > file_.size() - at;
  };
  int64_t from = offset;
  while (const auto sync = FindSync(from, file_.size())) {
    if (is_cut(*sync)) return true;
    from = *sync + 1;
  }
  // The last bytes may be the beginning of a sync word.
  for (int64_t at = std::max(offset, file_.size() - 3); at < file_.size(); ++at) {
    if (BeginsWithSync(Peek(at, kNumberEnd))) return true;
  }
  return false;
}

std::optional<int64_t> EventFinder::FindSync(int64_t from, int64_t limit) {
  constexpr auto kSyncBytes = static_cast<int64_t>(kSyncWord.size());
  budget_ -= kLookBytes;
  while (from + kSyncBytes <= limit) {
    // The window stands still while it is searched, however many sync words it holds.
    const int64_t start = from / kSearchBytes * kSearchBytes;
    if (!search_.Holds(start, kSearchBytes)) budget_ -= kSearchBytes;
    const auto chunk = search_.View(start, kSearchBytes + kSyncBytes - 1);
    const auto bytes = chunk.subspan(static_cast<size_t>(from - start));
    if (const void* at = memmem(bytes.data(), bytes.size(), kSyncWord.data(), kSyncWord.size())) {
      const int64_t found = from + (static_cast<const uint8_t*>(at) - bytes.data());
      budget_ -= found - from;
      return found + kSyncBytes <= limit ? std::optional(found) : std::nullopt;
    }
    budget_ -= std::ssize(bytes);
    from = start + kSearchBytes;
  }
  return std::nullopt;
}

}  // namespace sprout
