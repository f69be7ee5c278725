#include "common/frames/sequence_gaps.h"

namespace sprout {
namespace {

// Most numbers that one jump within a stream leaves out: more is a stray message, or another
// stream.
constexpr int64_t kMaxLeftOut = 1'000'000;

// Streams that are remembered, and for how many frames one without a frame of its own is.
constexpr size_t kMaxStreams = 4;
constexpr int64_t kMaxSilence = 64;

// Numbers between two frames; nothing when the one does not continue the other. Both are at least
// −1, so no difference overflows.
std::optional<int64_t> LeftOut(int64_t seq, int64_t next_seq) {
  if (next_seq <= seq || next_seq - 1 - seq > kMaxLeftOut) return std::nullopt;
  return next_seq - 1 - seq;
}

}  // namespace

bool SequenceGaps::Add(const FrameId& id) {
  ++added_;
  while (streams_.size() > kMaxStreams ||
         (streams_.size() > 1 && added_ - streams_.front().added > kMaxSilence)) {
    streams_.pop_front();
  }
  const std::optional<Continued> continued = Find(id);
  if (!continued) {
    const bool first = streams_.empty();
    const bool started_again = !first && id.seq <= streams_.back().newest.seq;
    if (!first && !(started_again && id.utime > streams_.back().newest.utime)) return AddAside(id);
    Begin(id, /*goes_on_beside=*/false);
    return started_again;
  }
  const auto [stream, left_out] = *continued;
  const bool is_newest = stream + 1 == streams_.size();
  const bool goes_on_beside = !is_newest || streams_[stream].goes_on_beside;
  count_ += left_out;
  if (id.utime <= streams_[stream].newest.utime) ++times_back_;
  // What was before a jump stays: it may be a frame of another stream.
  if (left_out == 0 || !is_newest) {
    streams_.erase(streams_.begin() + static_cast<std::ptrdiff_t>(stream));
  }
  Begin(id, goes_on_beside);
  return false;
}

// The stream that a frame continues with the fewest numbers left out; of equal ones the newest.
std::optional<SequenceGaps::Continued> SequenceGaps::Find(const FrameId& id) const {
  std::optional<Continued> best;
  for (size_t i = streams_.size(); i-- > 0;) {
    const auto left_out = LeftOut(streams_[i].newest.seq, id.seq);
    const bool is_newest = i + 1 == streams_.size();
    if (!left_out || (*left_out > 0 && !is_newest && !streams_[i].goes_on_beside)) continue;
    if (!best || *left_out < best->left_out) best = {.stream = i, .left_out = *left_out};
  }
  return best;
}

void SequenceGaps::Begin(const FrameId& id, bool goes_on_beside) {
  streams_.push_back({.newest = id, .added = added_, .goes_on_beside = goes_on_beside});
  aside_.reset();
}

bool SequenceGaps::AddAside(const FrameId& id) {
  const auto left_out = aside_ ? LeftOut(aside_->newest_seq, id.seq) : std::nullopt;
  if (!left_out) {
    aside_ = Aside{.newest_seq = id.seq};
    return false;
  }
  aside_->newest_seq = id.seq;
  aside_->gaps += *left_out;
  if (++aside_->frames < kRestartFrames) return false;
  count_ += aside_->gaps;
  Begin(id, /*goes_on_beside=*/false);
  return true;
}

}  // namespace sprout
