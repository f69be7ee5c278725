#include "services/batch/shard_plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <type_traits>

#include "common/app/replay.h"
#include "common/bus/channels.h"
#include "common/core/digest.h"
#include "common/frames/frame_joiner.h"

namespace sprout::batch {
namespace {

// More than a joiner remembers; the newest.
constexpr size_t kCarriedRigs = 16;

// What stands for a part when only its being there matters.
PartValue EmptyValue(Part part) {
  return std::visit(
      [](auto member) -> PartValue {
        using Member = std::remove_reference_t<decltype(std::declval<Frame>().*member)>;
        if constexpr (std::is_same_v<Member, cv::Mat>) {
          return cv::Mat();
        } else {
          return typename Member::value_type();
        }
      },
      RowOf(part).member);
}

// Follows what the first stage's replay would hold and answer, message by message, with the joiner
// that the replay has.
class ReplayFollower {
 public:
  explicit ReplayFollower(PartSet needed) : needed_(needed), joiner_(needed, kReplayMaxPending) {}

  // The first calibration of a log holds from its start, wherever it stands.
  void AddFirstRig(const IndexedEvent& event) {
    joiner_.Add(event.id, Part::kRig, Rig());
    RememberRig(event);
  }

  /// @returns the frames that are complete now.
  std::vector<Frame> Add(const IndexedEvent& event, Part part) {
    if (part == Part::kRig) RememberRig(event);
    if (!needed_.Has(part)) return {};
    if (part != Part::kRig) open_.push_back({event.id, event.line});
    std::vector<Frame> complete = joiner_.Add(event.id, part, EmptyValue(part));
    if (!complete.empty() || open_.size() > kReplayMaxPending * kPartCount) {
      std::erase_if(open_, [&](const Open& open) { return !joiner_.IsPending(open.id); });
    }
    return complete;
  }

  // The log has ended.
  void Count(LogPlan& plan) {
    joiner_.DropPending();
    plan.incomplete = joiner_.incomplete();
    plan.left_out = joiner_.sequence_gaps();
  }

  // Lines of what is held, in the order of the log.
  std::vector<int64_t> Held() const {
    std::vector<int64_t> lines;
    for (const auto& [rig_id, line] : rigs_) lines.push_back(line);
    for (const Open& open : open_) {
      if (joiner_.IsPending(open.id)) lines.push_back(open.line);
    }
    std::sort(lines.begin(), lines.end());
    return lines;
  }

 private:
  struct Open {
    FrameId id;
    int64_t line;
  };

  void RememberRig(const IndexedEvent& event) {
    std::erase_if(rigs_, [&](const auto& known) { return known.first == event.id.rig_id; });
    rigs_.emplace_back(event.id.rig_id, event.line);
    if (rigs_.size() > kCarriedRigs) rigs_.erase(rigs_.begin());
  }

  PartSet needed_;
  FrameJoiner joiner_;
  std::vector<std::pair<std::string, int64_t>> rigs_;  // rig_id and line, in order of arrival
  std::vector<Open> open_;                             // messages of unfinished frames
};

// The messages that the chain takes, with their parts.
struct Taken {
  const IndexedEvent* event;
  Part part;
};

std::vector<Taken> TakenOf(const LogIndex& index, const PlanOptions& options) {
  std::vector<Taken> taken;
  for (const IndexedEvent& event : index.events()) {
    const std::optional<Part> part = PartOf(event.channel, options.prefix);
    if (part && options.inputs.all.Has(*part)) taken.push_back({&event, *part});
  }
  return taken;
}

class Planner {
 public:
  Planner(const LogIndex& index, const PlanOptions& options)
      : taken_(TakenOf(index, options)), follower_(options.inputs.first) {
    int64_t total = 0;
    for (const Taken& taken : taken_) {
      total += taken.event->bytes;
    }
    const bool whole =
        !index.summary().cuttable || !options.inputs.first_has_all || options.inputs.has_memory;
    const int64_t count =
        whole ? 1 : std::max<int64_t>(1, (total + options.shard_bytes / 2) / options.shard_bytes);
    share_ = (total + count - 1) / std::max<int64_t>(count, 1);
  }

  LogPlan Plan() {
    const std::vector<bool> in_order_behind = InOrderBehind();
    const auto first_rig = std::find_if(
        taken_.begin(), taken_.end(), [](const Taken& taken) { return taken.part == Part::kRig; });
    if (first_rig != taken_.end()) follower_.AddFirstRig(*first_rig->event);
    Begin(0);
    int64_t bytes = 0;
    int64_t wanted = share_;  // the next multiple of a share
    for (size_t i = 0; i < taken_.size(); ++i) {
      bytes += taken_[i].event->bytes;
      const std::vector<Frame> complete = follower_.Add(*taken_[i].event, taken_[i].part);
      for (const Frame& frame : complete) Count(frame.id);
      if (!complete.empty() && bytes >= wanted && in_order_behind[i]) {
        wanted = (bytes / share_ + 1) * share_;
        Finish(i + 1);
        Begin(i + 1);
      }
    }
    // What is left without a complete frame has no answer.
    if (shard_.frames > 0) Finish(taken_.size());
    follower_.Count(plan_);
    return std::move(plan_);
  }

 private:
  // Behind which messages nothing is older than anything before. Only there may a shard end: a
  // stage merges the log with the answers of others by time, and a late message waits for those
  // before it.
  std::vector<bool> InOrderBehind() const {
    std::vector<bool> in_order(taken_.size());
    std::vector<int64_t> oldest_behind(taken_.size());
    int64_t oldest = std::numeric_limits<int64_t>::max();
    for (size_t i = taken_.size(); i-- > 0;) {
      oldest_behind[i] = oldest;
      oldest = std::min(oldest, taken_[i].event->utime);
    }
    int64_t newest = std::numeric_limits<int64_t>::min();
    for (size_t i = 0; i < taken_.size(); ++i) {
      newest = std::max(newest, taken_[i].event->utime);
      in_order[i] = newest <= oldest_behind[i];
    }
    return in_order;
  }

  void Begin(size_t at) {
    shard_ = Shard{};
    first_ = at;
    shard_.carried = follower_.Held();
    shard_.begin = at < taken_.size() ? taken_[at].event->line : 0;
  }

  void Count(const FrameId& id) {
    if (shard_.frames++ == 0) shard_.first_seq = id.seq;
    shard_.last_seq = id.seq;
  }

  const IndexedEvent& EventAt(int64_t line) const {
    return *std::lower_bound(taken_.begin(), taken_.end(), line,
                             [](const Taken& taken, int64_t at) { return taken.event->line < at; })
                ->event;
  }

  void Finish(size_t end) {
    std::vector<IndexedEvent> carried;
    std::vector<IndexedEvent> own;
    for (const int64_t line : shard_.carried) carried.push_back(EventAt(line));
    for (size_t i = first_; i < end; ++i) own.push_back(*taken_[i].event);
    for (const auto* events : {&carried, &own}) {
      for (const IndexedEvent& event : *events) shard_.bytes += event.bytes;
    }
    shard_.end = own.back().line_end;
    shard_.input = InputDigest(carried, own);
    plan_.shards.push_back(std::move(shard_));
    shard_ = Shard{};
  }

  std::vector<Taken> taken_;
  ReplayFollower follower_;
  int64_t share_ = 0;  // bytes of a shard
  LogPlan plan_;
  Shard shard_;
  size_t first_ = 0;  // of taken_ in shard_
};

}  // namespace

std::vector<std::string> ChannelsOf(const ChainInputs& inputs, const std::string& prefix) {
  std::vector<std::string> channels;
  for (const Part part : kAllParts) {
    if (inputs.all.Has(part)) channels.push_back(prefix + std::string(ChannelOf(part)));
  }
  return channels;
}

std::string InputDigest(const std::vector<IndexedEvent>& carried,
                        const std::vector<IndexedEvent>& own) {
  std::string text;
  for (const auto* events : {&carried, &own}) {
    for (const IndexedEvent& event : *events) {
      text += fmt::format("{} {} {:x}\n", event.channel, event.utime, event.hash);
    }
    text += "\n";
  }
  return Digest(text);
}

LogPlan PlanShards(const LogIndex& index, const PlanOptions& options) {
  return Planner(index, options).Plan();
}

}  // namespace sprout::batch
