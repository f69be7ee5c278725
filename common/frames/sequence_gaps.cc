#include "common/frames/sequence_gaps.h"

namespace sprout {
namespace {

// Most numbers that one jump within a stream leaves out: more is a stray message, or another
// stream.
constexpr int64_t kMaxLeftOut = 1'000'000;

// Numbers between two frames; nothing when the one does not continue the other. Both are at least
// −1, so no difference overflows.
std::optional<int64_t> LeftOut(int64_t seq, int64_t next_seq) {
  if (next_seq <= seq || next_seq - 1 - seq > kMaxLeftOut) return std::nullopt;
  return next_seq - 1 - seq;
}

}  // namespace

bool SequenceGaps::Add(const FrameId& id) {
  const bool first = !newest_;
  const bool started_again = !first && id.seq <= newest_->seq && id.utime > newest_->utime;
  const auto left_out = first || started_again ? 0 : LeftOut(newest_->seq, id.seq);
  if (!left_out) return AddAside(id);
  count_ += *left_out;
  newest_ = id;
  aside_.reset();
  return started_again;
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
  newest_ = id;
  aside_.reset();
  return true;
}

}  // namespace sprout
