#include "common/frames/whole_frames.h"

#include <algorithm>
#include <utility>

#include "common/messages/codec.h"

namespace sprout {

WholeFrames::WholeFrames(const std::filesystem::path& path, std::string prefix, PartSet needed,
                         Refuse refuse)
    : prefix_(std::move(prefix)),
      needed_(needed),
      refuse_(std::move(refuse)),
      reader_(path),
      joiner_(needed) {}

void WholeFrames::AddRig(std::span<const uint8_t> message) {
  static_cast<void>(joiner_.AddMessage(Part::kRig, message));
}

std::optional<WholeFrame> WholeFrames::Next() {
  for (LogEvent event; ready_.empty() && reader_.Next(event);) Take(event);
  if (ready_.empty()) {
    joiner_.DropPending();
    return std::nullopt;
  }
  WholeFrame next = std::move(ready_.front());
  ready_.pop_front();
  return next;
}

void WholeFrames::Take(const LogEvent& event) {
  channels_.Add(event.channel);
  const std::optional<Part> part = PartOf(event.channel, prefix_);
  if (!part || (part != Part::kRig && !needed_.Has(*part))) return;
  Result<std::vector<Frame>> whole = joiner_.AddMessage(*part, event.data);
  if (!whole) return refuse_(event, whole.error().text);
  if (part == Part::kRig) {
    newest_rig_ = event.offset;
  } else {
    PlacesOf(*DecodeFrameId(event.data)).offset(*part) = event.offset;
  }
  for (Frame& frame : *whole) {
    IndexedFrame places = PlacesOf(frame.id);
    ready_.push_back({std::move(frame), std::move(places)});
  }
  std::erase_if(pending_, [&](const IndexedFrame& one) { return !joiner_.IsPending(one.id); });
}

IndexedFrame& WholeFrames::PlacesOf(const FrameId& id) {
  const auto found = std::ranges::find(pending_, id, &IndexedFrame::id);
  return found != pending_.end() ? *found : pending_.emplace_back(id);
}

}  // namespace sprout
