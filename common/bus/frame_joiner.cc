#include "common/bus/frame_joiner.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace sprout {
namespace {

// Calibrations, and frames completed or dropped, that are remembered. A graph has one rig; a second
// one appears when capture restarts with another.
constexpr size_t kMaxRigs = 4;
constexpr size_t kMaxAccounted = 64;

// Most frame numbers that one jump counts as left out: more is a stray message or another stream,
// and an endless count would overflow.
constexpr int64_t kMaxGap = 1'000'000;

}  // namespace

FrameJoiner::FrameJoiner(PartSet needed, size_t max_pending)
    : needed_(needed), max_pending_(max_pending) {
  assert(needed != PartSet{} && needed != PartSet{Part::kRig} && max_pending > 0);
}

std::vector<Frame> FrameJoiner::Add(const FrameId& id, Part part, PartValue value) {
  if (part == Part::kRig) {
    std::erase_if(rigs_, [&](const auto& known) { return known.first == id.rig_id; });
    rigs_.emplace_back(id.rig_id, std::get<Rig>(std::move(value)));
    if (rigs_.size() > kMaxRigs) rigs_.pop_front();
  } else {
    Pending& pending = FindOrStart(id);
    SetPart(pending.frame, part, std::move(value));
    pending.present.Add(part);
  }
  return TakeComplete();
}

FrameJoiner::Pending& FrameJoiner::FindOrStart(const FrameId& id) {
  const auto found = std::find_if(pending_.begin(), pending_.end(),
                                  [&](const Pending& pending) { return pending.frame.id == id; });
  if (found != pending_.end()) return *found;
  CountGap(id);
  if (pending_.size() == max_pending_) {
    Drop(pending_.front());
    pending_.pop_front();
  }
  Pending& started = pending_.emplace_back();
  started.frame.id = id;
  return started;
}

void FrameJoiner::CountGap(const FrameId& id) {
  const bool restarted = newest_ && id.seq <= newest_->seq && id.utime > newest_->utime;
  if (newest_ && !restarted) {
    if (id.seq <= newest_->seq) return;  // sent again
    // Both are at least −1, and id.seq is the larger: no difference overflows.
    sequence_gaps_ += std::min(id.seq - 1 - newest_->seq, kMaxGap);
  }
  newest_ = id;
}

void FrameJoiner::Drop(const Pending& pending) {
  // Leftovers of a frame that was joined before (sent twice) or dropped before (a part came too
  // late) are not missed.
  if (IsAccountedFor(pending.frame.id)) return;
  ++incomplete_;
  Account(pending.frame.id);
}

void FrameJoiner::DropPending() {
  for (const Pending& pending : pending_) Drop(pending);
  pending_.clear();
}

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

bool FrameJoiner::IsComplete(const Pending& pending) const {
  return std::all_of(std::begin(kAllParts), std::end(kAllParts), [&](Part part) {
    if (!needed_.Has(part)) return true;
    return part == Part::kRig ? FindRig(pending.frame.id.rig_id).has_value()
                              : pending.present.Has(part);
  });
}

std::vector<Frame> FrameJoiner::TakeComplete() {
  std::vector<Frame> complete;
  size_t hopeless = 0;  // every pending frame before this one
  for (size_t i = 0; i < pending_.size(); ++i) {
    if (!IsComplete(pending_[i])) continue;
    for (; hopeless < i; ++hopeless) Drop(pending_[hopeless]);
    hopeless = i + 1;
    Frame& frame = pending_[i].frame;
    if (needed_.Has(Part::kRig)) frame.rig = FindRig(frame.id.rig_id);
    Account(frame.id);
    complete.push_back(std::move(frame));
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(hopeless));
  return complete;
}

}  // namespace sprout
