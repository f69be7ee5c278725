#include "services/batch/frame_lookup.h"

#include <algorithm>
#include <optional>
#include <set>

#include "common/frames/log_frames.h"
#include "common/logfile/event_format.h"
#include "common/logfile/file_window.h"

namespace sprout::batch {
namespace {

// Of a message, enough to know its frame; images need not be read for it.
constexpr int64_t kHeadBytes = 1024;

}  // namespace

FrameLookup::Log& FrameLookup::Open(const std::string& log) {
  const FrameChoice choice{.prefix = prefix_, .look_back = FrameChoice::kWholeLog};
  return logs_.emplace_back(log, choice);
}

void FrameLookup::Add(const std::string& log) {
  FrameIndex& index = Open(log).index;
  const InputFile file(log);
  FileWindow window(file, kHeadBytes);
  for (int64_t offset = 0; offset < file.size();) {
    const auto head = window.View(offset, kHeadBytes);
    const auto header = DecodeHeader(head);
    if (!header || !IsPlausible(*header, head) || header->event_bytes() > file.size() - offset) {
      throw LogError(log, "damaged; remove its folder, and the shard is computed again");
    }
    const auto bytes = std::min(header->event_bytes(), std::ssize(head));
    index.Add(MakeEvent(*header, offset, head.first(static_cast<size_t>(bytes))));
    offset += header->event_bytes();
  }
}

void FrameLookup::Add(const std::string& log, std::span<const IndexedEvent> events) {
  FrameIndex& index = Open(log).index;
  for (const IndexedEvent& event : events) {
    const std::optional<Part> part = PartOf(event.channel, prefix_);
    if (part && part != Part::kRig) index.Add(*part, event.id, event.offset);
  }
}

std::vector<FrameId> FrameLookup::FramesWith(Part part) const {
  std::vector<FrameId> frames;
  std::set<FrameId> seen;
  for (const Log& log : logs_) {
    for (const IndexedFrame& frame : log.index.frames()) {
      if (frame.Has(part) && seen.insert(frame.id).second) frames.push_back(frame.id);
    }
  }
  return frames;
}

Frame FrameLookup::Get(const FrameId& id, const PartSet& parts) {
  Frame frame;
  frame.id = id;
  for (Log& log : logs_) {
    const IndexedFrame* const places = log.index.Find(id);
    if (places == nullptr) continue;
    for (auto& [part, value] : FetchParts(log.fetcher, *places, parts)) {
      SetPart(frame, part, std::move(value));
    }
  }
  return frame;
}

}  // namespace sprout::batch
