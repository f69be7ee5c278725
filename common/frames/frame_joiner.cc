#include "common/frames/frame_joiner.h"

#include <algorithm>
#include <cassert>

#include "common/messages/codec.h"

namespace sprout {
namespace {

// Calibrations, and frames completed or dropped, that are remembered. A graph has one rig; a second
// one appears when capture restarts with another, or puts its calibration right.
constexpr size_t kMaxRigs = 4;
constexpr size_t kMaxAccounted = 64;

}  // namespace

FrameJoiner::FrameJoiner(PartSet needed, size_t max_pending, size_t max_bytes, PartSet optional)
    : needed_(needed), optional_(optional), max_pending_(max_pending), max_bytes_(max_bytes) {
  assert(needed != PartSet{} && needed != PartSet{Part::kRig} && max_pending > 0);
}

std::vector<Frame> FrameJoiner::Add(const FrameId& id, Part part, PartValue value) {
  if (part == Part::kRig) {
    const Rig& rig = std::get<Rig>(value);
    if (const auto known = FindRig(id.rig_id); known && RigId(*known) != RigId(rig)) {
      ++rigs_replaced_;
    }
    std::erase_if(rigs_, [&](const auto& known) { return known.first == id.rig_id; });
    rigs_.emplace_back(id.rig_id, rig);
    if (rigs_.size() > kMaxRigs) rigs_.pop_front();
  } else {
    Pending& pending = FindOrStart(id);
    SetPart(pending.frame, part, std::move(value));
    pending.present.Add(part);
  }
  std::vector<Frame> complete = TakeFirst(CountReady());
  KeepWithinBudget();
  return complete;
}

Result<std::vector<Frame>> FrameJoiner::AddMessage(Part part, std::span<const uint8_t> bytes,
                                                   const cv::Mat1b& memory) {
  const Result<FrameId> id = DecodeFrameId(bytes);
  Result<DecodedPart> decoded =
      DecodePart(part, bytes, id ? ImageSizeOf(*id) : std::nullopt, memory);
  if (!decoded) return tl::unexpected(decoded.error());
  return Add(decoded->id, part, std::move(decoded->value));
}

// Index of a pending frame; the number of pending frames if it is not among them.
size_t FrameJoiner::IndexOf(const FrameId& id) const {
  size_t i = 0;
  while (i < pending_.size() && pending_[i].frame.id != id) ++i;
  return i;
}

bool FrameJoiner::IsPending(const FrameId& id) const { return IndexOf(id) < pending_.size(); }

std::optional<cv::Size> FrameJoiner::ImageSizeOf(const FrameId& id) const {
  if (const std::optional<Rig> rig = FindRig(id.rig_id)) return rig->pair.size();
  return IsPending(id) ? ImageSize(pending_[IndexOf(id)].frame) : std::nullopt;
}

FrameJoiner::Pending& FrameJoiner::FindOrStart(const FrameId& id) {
  if (IsPending(id)) return pending_[IndexOf(id)];
  // Frames of a recording that plays again have the names that they had before. Those of a capture
  // that was started again have new ones, and leftovers of the old ones may still be here.
  const auto is_later = [&](const FrameId& other) { return other.utime >= id.utime; };
  if (gaps_.Add(id) && std::any_of(accounted_.begin(), accounted_.end(), is_later)) {
    accounted_.clear();
  }
  if (pending_.size() == max_pending_) DropOldest();
  Pending& started = pending_.emplace_back();
  started.frame.id = id;
  return started;
}

void FrameJoiner::DropOldest() {
  Drop(pending_.front());
  pending_.pop_front();
}

void FrameJoiner::KeepWithinBudget() {
  size_t bytes = 0;
  for (const Pending& pending : pending_) bytes += BytesOf(pending.frame);
  while (bytes > max_bytes_) {
    bytes -= BytesOf(pending_.front().frame);
    DropOldest();
  }
}

void FrameJoiner::Drop(const Pending& pending) {
  // Leftovers of a frame that was joined before (sent twice) or dropped before (a part came too
  // late) are not missed.
  if (IsAccountedFor(pending.frame.id)) return;
  ++incomplete_;
  Account(pending.frame.id);
}

std::vector<Frame> FrameJoiner::DropPending() { return TakeFirst(pending_.size()); }

bool FrameJoiner::IsAccountedFor(const FrameId& id) const {
  return std::find(accounted_.begin(), accounted_.end(), id) != accounted_.end();
}

void FrameJoiner::Account(const FrameId& id) {
  accounted_.push_back(id);
  if (accounted_.size() > kMaxAccounted) accounted_.pop_front();
}

std::optional<Rig> FrameJoiner::FindRig(const std::string& rig_id) const {
  for (const auto& [known_id, rig] : rigs_) {
    if (known_id == rig_id) return rig;
  }
  return std::nullopt;
}

bool FrameJoiner::Has(const Pending& pending, Part part) const {
  return part == Part::kRig ? FindRig(pending.frame.id.rig_id).has_value()
                            : pending.present.Has(part);
}

bool FrameJoiner::IsComplete(const Pending& pending) const {
  return std::ranges::all_of(kAllParts,
                             [&](Part part) { return !needed_.Has(part) || Has(pending, part); });
}

bool FrameJoiner::LacksOptionalOnly(const Pending& pending) const {
  return std::ranges::all_of(kAllParts, [&](Part part) {
    return !needed_.Has(part) || optional_.Has(part) || Has(pending, part);
  });
}

// Frames up to the last one that waits for nothing.
size_t FrameJoiner::CountReady() const {
  size_t ready = 0;
  size_t last_usable = pending_.size();
  for (size_t i = 0; i < pending_.size(); ++i) {
    if (!LacksOptionalOnly(pending_[i])) continue;
    if (last_usable < i) ready = last_usable + 1;
    if (IsComplete(pending_[i])) ready = i + 1;
    last_usable = i;
  }
  return ready;
}

// Takes the usable ones of them; the others cannot be completed any more.
std::vector<Frame> FrameJoiner::TakeFirst(size_t count) {
  std::vector<Frame> usable;
  for (size_t i = 0; i < count; ++i) {
    if (!LacksOptionalOnly(pending_[i])) {
      Drop(pending_[i]);
      continue;
    }
    Frame& frame = pending_[i].frame;
    if (needed_.Has(Part::kRig)) frame.rig = FindRig(frame.id.rig_id);
    Account(frame.id);
    usable.push_back(std::move(frame));
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(count));
  return usable;
}

}  // namespace sprout
