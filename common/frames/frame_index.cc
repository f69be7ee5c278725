#include "common/frames/frame_index.h"

#include "common/core/printable.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"

namespace sprout {
namespace {

// A hostile log could have any number.
constexpr size_t kMaxRigsOfLog = 1000;

}  // namespace

void FrameIndex::Add(const LogEvent& event, const Refuse& refuse) {
  const std::optional<Part> part = PartOf(event.channel, choice_.prefix);
  if (!part) {
    if (TypeOfChannel(event.channel)) other_channel_ = event.channel;
    return;
  }
  has_channel_ = true;
  if (part == Part::kRig) return AddRig(event, refuse);
  const Result<FrameId> id = DecodeFrameId(event.data);
  if (!choice_.parts.Has(*part) || (id && !choice_.frames.Has(id->seq))) return;
  if (id && TypeOf(event.data) == TypeOf(*part)) {
    Add(*part, *id, event.offset);
  } else if (const auto decoded = DecodePart(*part, event.data); !decoded && refuse) {
    refuse(event, decoded.error().text);
  }
}

void FrameIndex::Add(Part part, const FrameId& id, int64_t offset) {
  const auto [newest, is_new] = newest_.try_emplace(id, frames_.size());
  if (!is_new && frames_.size() - newest->second > choice_.look_back) {
    newest->second = frames_.size();
  }
  if (newest->second == frames_.size()) frames_.emplace_back(id);
  int64_t& place = frames_[newest->second].offset(part);
  if (place >= 0) repeats_.push_back({id, part, place, offset});
  place = offset;
}

void FrameIndex::AddRig(const LogEvent& event, const Refuse& refuse) {
  if (PartOf(event.channel, choice_.prefix) != Part::kRig) return;
  const Result<DecodedPart> decoded = DecodePart(Part::kRig, event.data);
  if (!decoded) return refuse ? refuse(event, decoded.error().text) : void();
  const std::string& rig_id = decoded->id.rig_id;
  std::string digest = RigId(std::get<Rig>(decoded->value));
  if (const auto known = rigs_.find(rig_id); known == rigs_.end()) {
    if (rigs_.size() < kMaxRigsOfLog) rigs_[rig_id] = {event.offset, std::move(digest)};
  } else if (refuse && known->second.digest != digest) {
    refuse(event, "rig_id '" + Printable(rig_id) + "' again, with other numbers; the first count");
  }
}

const IndexedFrame* FrameIndex::Find(const FrameId& id) const {
  const auto found = newest_.lower_bound(id);
  if (found == newest_.end()) return nullptr;
  const FrameId& name = found->first;
  const bool is_rig = id.rig_id.empty() || name.rig_id == id.rig_id;
  if (name.utime != id.utime || name.seq != id.seq || !is_rig) return nullptr;
  return &frames_[found->second];
}

IndexedFrame FrameIndex::At(size_t number) const {
  IndexedFrame frame = frames_[number];
  const auto rig = rigs_.find(frame.id.rig_id);
  if (rig != rigs_.end()) frame.offset(Part::kRig) = rig->second.offset;
  return frame;
}

std::string FrameIndex::OtherPrefixText() const {
  if (has_channel_ || other_channel_.empty()) return "";
  return "there are channels as " + other_channel_ + ", see --channel-prefix";
}

}  // namespace sprout
