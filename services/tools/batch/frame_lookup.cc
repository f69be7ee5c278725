#include "services/tools/batch/frame_lookup.h"

#include <set>

#include "common/frames/log_frames.h"
#include "common/logfile/log_reader.h"

namespace sprout::batch {

void FrameLookup::Add(const std::filesystem::path& log, const PartSet& parts) {
  const FrameChoice choice{.prefix = prefix_, .parts = parts, .look_back = FrameChoice::kWholeLog};
  FrameIndex& index = logs_.emplace_back(log, choice).index;
  LogReader reader(log);
  for (LogEvent event; reader.Next(event);) index.Add(event);
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

std::optional<int64_t> FrameLookup::PlaceOf(const FrameId& id, Part part) const {
  for (const Log& log : logs_) {
    const IndexedFrame* const places = log.index.Find(id);
    if (places != nullptr && places->Has(part)) return places->offset(part);
  }
  return std::nullopt;
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
