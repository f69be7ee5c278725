#include "services/tools/log/sequence.h"

#include <algorithm>
#include <limits>

namespace sprout::log {
namespace {

constexpr size_t kRecentFrames = 64;  // as far back a frame may come again
constexpr size_t kShownGaps = 10;

}  // namespace

std::optional<int64_t> Sequence::last() const {
  return newest_ ? std::optional(newest_->seq) : std::nullopt;
}

void Sequence::Add(const FrameId& id) {
  if (std::find(recent_.begin(), recent_.end(), id) != recent_.end()) {
    ++repeated_;
    return;
  }
  recent_.push_back(id);
  if (recent_.size() > kRecentFrames) recent_.pop_front();
  if (!first_) first_ = id.seq;
  if (newest_ && id.seq - 1 > newest_->seq) {
    const Gap gap{newest_->seq + 1, id.seq - 1};
    // A damaged number can be anything; the sum must not overflow.
    if (__builtin_add_overflow(missing_, gap.last - gap.first + 1, &missing_)) {
      missing_ = std::numeric_limits<int64_t>::max();
    }
    ++gap_count_;
    if (gaps_.size() < kShownGaps) gaps_.push_back(gap);
  } else if (newest_ && id.seq <= newest_->seq) {
    if (id.utime <= newest_->utime) return;  // late; not the newest
    ++restarts_;
  }
  newest_ = id;
}

std::string Sequence::GapText() const {
  std::string text;
  for (const Gap& gap : gaps_) {
    if (!text.empty()) text += ", ";
    text += std::to_string(gap.first);
    if (gap.last > gap.first) text += "-" + std::to_string(gap.last);
  }
  return gap_count_ > static_cast<int64_t>(gaps_.size()) ? text + ", ..." : text;
}

}  // namespace sprout::log
