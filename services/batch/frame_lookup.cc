#include "services/batch/frame_lookup.h"

#include "common/bus/channels.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"

namespace sprout {

void FrameLookup::Add(const std::string& log) {
  const size_t number = fetchers_.size();
  fetchers_.emplace_back(log);
  LogReader reader(log);
  for (LogEvent event; reader.Next(event);) {
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

}  // namespace sprout
