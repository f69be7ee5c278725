#include "common/logfile/log_reader.h"

namespace sprout {
namespace {

constexpr int64_t kChunkBytes = int64_t{1} << 20;  // of a log that is read in order
constexpr int64_t kEventBytes = 4096;              // of single events

bool IsNext(const EventPosition& before, const EventPosition& event) {
  return event.header.number > 0 && event.header.number - 1 == before.header.number;
}

// The event in these bytes, which begin at `offset`, as views.
LogEvent MakeEvent(const EventHeader& header, int64_t offset, std::span<const uint8_t> bytes) {
  const auto channel = bytes.subspan(kHeaderBytes, static_cast<size_t>(header.channel_bytes));
  return {.number = header.number,
          .utime = header.utime,
          .offset = offset,
          .channel = {reinterpret_cast<const char*>(channel.data()), channel.size()},
          .data = bytes.subspan(kHeaderBytes + channel.size())};
}

// What else lies where logs do, and what to do with it.
std::string OtherFormat(std::span<const uint8_t> begin) {
  const std::string_view text(reinterpret_cast<const char*>(begin.data()), begin.size());
  if (text.starts_with("\x1f\x8b")) return ": packed with gzip; unpack it with gunzip";
  if (text.starts_with("\x28\xb5\x2f\xfd")) return ": packed with zstd; unpack it with unzstd";
  if (text.starts_with("\x89MCAP0")) {
    return ": a bag of ROS 2; sprout-capture --source mcap:FILE?left=TOPIC&right=TOPIC reads it";
  }
  return "";
}

}  // namespace

std::string SkippedText(const LogDamage& damage) {
  return std::to_string(damage.bytes) + " unreadable bytes at byte " +
         std::to_string(damage.offset) + (damage.tail ? ": it ends inside an event" : ", skipped");
}

LogReader::LogReader(const std::filesystem::path& path)
    : file_(path), window_(file_, kChunkBytes), finder_(file_, window_), ahead_(FindNext()) {
  const auto begin = window_.View(0, kMinEventBytes);
  if (!ahead_ && !BeginsWithSync(begin))
    throw LogError(path, "not an LCM log" + OtherFormat(begin));
}

std::optional<EventPosition> LogReader::FindNext() {
  if (position_ >= file_.size()) return std::nullopt;
  const auto event = finder_.EventAt(position_, trusted_);
  return event ? event : finder_.EventAfter(position_, trusted_);
}

// One damaged number must not make the good ones behind it look wrong; two that follow each other
// do begin a new sequence, as in logs that were put one behind the other.
void LogReader::Trust(const EventPosition& event) {
  if (IsInSequence(trusted_, event) || (last_ && IsNext(*last_, event))) trusted_ = event;
}

// Books what lies between the last event and the next one, or the end of the file.
void LogReader::Skip(const std::optional<EventPosition>& next) {
  const int64_t end = next ? next->offset : file_.size();
  if (end == position_) return;
  LogDamage damage{.offset = position_, .bytes = end - position_, .tail = false, .events = {}};
  if (!next) {
    damage.tail = finder_.IsTorn(position_);
  } else if (IsInSequence(last_, *next)) {
    damage.events = next->header.number - (last_ ? last_->header.number : -1) - 1;
  }
  damage_.push_back(damage);
}

bool LogReader::Next(LogEvent& event) {
  const std::optional<EventPosition> next = ahead_ ? ahead_ : FindNext();
  ahead_.reset();
  Skip(next);
  position_ = next ? next->end() : file_.size();
  if (!next) return false;
  Trust(*next);
  last_ = next;
  event =
      MakeEvent(next->header, next->offset, window_.View(next->offset, next->header.event_bytes()));
  return true;
}

EventFetcher::EventFetcher(const std::filesystem::path& path)
    : file_(path), window_(file_, kEventBytes) {}

LogEvent EventFetcher::Fetch(int64_t offset) {
  const auto head = window_.View(offset, kMaxHeadBytes);
  const auto header = DecodeHeader(head);
  if (!header || !IsPlausible(*header, head) || header->event_bytes() > file_.size() - offset) {
    throw LogError(file_.path(), "changed while it was read");
  }
  return MakeEvent(*header, offset, window_.View(offset, header->event_bytes()));
}

}  // namespace sprout
