#include "services/batch/frame_lookup.h"

#include <algorithm>

#include "common/bus/channels.h"
#include "common/logfile/event_format.h"
#include "common/logfile/file_window.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"

namespace sprout::batch {
namespace {

// Of a message, enough to know its frame; images need not be read for it.
constexpr int64_t kHeadBytes = 1024;

}  // namespace

void FrameLookup::Add(const std::string& log) {
  const size_t number = fetchers_.size();
  fetchers_.emplace_back(log);
  const InputFile file(log);
  FileWindow window(file, kHeadBytes);
  for (int64_t offset = 0; offset < file.size();) {
    const auto head = window.View(offset, kHeadBytes);
    const auto header = DecodeHeader(head);
    if (!header || !IsPlausible(*header, head) || header->event_bytes() > file.size() - offset) {
      throw LogError(log, "damaged; remove its folder, and the shard is computed again");
    }
    const auto bytes = std::min(header->event_bytes(), std::ssize(head));
    const LogEvent event = MakeEvent(*header, offset, head.first(static_cast<size_t>(bytes)));
    offset += header->event_bytes();
    for (const Part part : kAllParts) {
      if (event.channel != prefix_ + std::string(ChannelOf(part))) continue;
      auto id = DecodeFrameId(event.data);
      if (!id || TypeOf(event.data) != TypeOf(part)) continue;
      Put(part, std::move(*id), {number, event.offset});
    }
  }
}

void FrameLookup::Add(const std::string& log, std::span<const IndexedEvent> events) {
  const size_t number = fetchers_.size();
  fetchers_.emplace_back(log);
  for (const IndexedEvent& event : events) {
    for (const Part part : kAllParts) {
      if (event.channel != prefix_ + std::string(ChannelOf(part))) continue;
      Put(part, event.id, {number, event.offset});
    }
  }
}

void FrameLookup::Put(Part part, FrameId id, Place place) {
  const bool is_new = places_[part].insert_or_assign(Key(id.utime, id.seq), place).second;
  if (is_new) frames_[part].push_back(std::move(id));
}

const std::vector<FrameId>& FrameLookup::FramesWith(Part part) const {
  static const std::vector<FrameId> kNone;
  const auto found = frames_.find(part);
  return found == frames_.end() ? kNone : found->second;
}

Frame FrameLookup::Get(const FrameId& id, const PartSet& parts) {
  Frame frame;
  frame.id = id;
  for (const Part part : kAllParts) {
    if (!parts.Has(part) || !places_.contains(part)) continue;
    const auto found = places_.at(part).find(Key(id.utime, id.seq));
    if (found == places_.at(part).end()) continue;
    const LogEvent event = fetchers_[found->second.log].Fetch(found->second.offset);
    if (auto decoded = DecodePart(part, event.data)) {
      SetPart(frame, part, std::move(decoded->value));
    }
  }
  return frame;
}

}  // namespace sprout::batch
