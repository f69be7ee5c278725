#include "services/snapshot/graph_listener.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/channels.h"
#include "common/messages/codec.h"

namespace sprout {
namespace {

// Stages whose status is kept; a graph has four. Names are free, so anybody could invent more.
constexpr size_t kMaxStages = 32;

// What it shows.
const PartSet kShownParts{Part::kLeft,     Part::kRight,     Part::kTof,
                          Part::kRig,      Part::kSeeds,     Part::kPrior,
                          Part::kUnfilled, Part::kDisparity, Part::kConfidence};

std::vector<std::string_view> WithStatus(std::vector<std::string_view> channels) {
  channels.push_back(kStatusChannel);
  return channels;
}

}  // namespace

GraphListener::GraphListener(const ServiceContext& context, StageMonitor& monitor)
    : monitor_(monitor),
      assembler_(kShownParts, monitor),
      receiver_(
          context.lcm_url, context.prefix, WithStatus(assembler_.channels()),
          [this](std::string_view channel, std::span<const uint8_t> bytes) {
            OnMessage(channel, bytes);
          },
          [this](std::string_view channel) { monitor_.MessageDropped(channel); }) {}

void GraphListener::OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
  if (channel == kStatusChannel) return OnStatus(bytes);
  const auto arrived = StageMonitor::Clock::now();
  for (Frame& frame : assembler_.Add(channel, bytes)) {
    monitor_.FrameIn(/*skipped=*/false);
    monitor_.FrameOut(frame.id, arrived, /*degenerate=*/"");
    const std::lock_guard lock(mutex_);
    seqs_.insert(frame.id.seq);
    newest_ = std::move(frame);
  }
  changed_.notify_all();
}

void GraphListener::OnStatus(std::span<const uint8_t> bytes) {
  Result<StageStatus> status = DecodeStatus(bytes);
  if (!status) return monitor_.BadMessage(kStatusChannel, status.error().text);
  const std::lock_guard lock(mutex_);
  if (statuses_.size() == kMaxStages && !statuses_.contains(status->stage)) {
    return monitor_.BadMessage(
        kStatusChannel, "from one more stage: allowed are up to " + std::to_string(kMaxStages));
  }
  statuses_[status->stage] = std::move(*status);
  changed_.notify_all();
}

int64_t GraphListener::WaitForFrames(int64_t count, Deadline deadline,
                                     const std::stop_token& stop) {
  const auto arrived = [this] { return static_cast<int64_t>(seqs_.size()); };
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, deadline, [&] { return arrived() >= count; });
  return arrived();
}

std::optional<Frame> GraphListener::newest_frame() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

std::map<std::string, StageStatus> GraphListener::WaitForStatuses(int64_t seq, Deadline deadline,
                                                                  const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, deadline, [&] {
    return !statuses_.empty() &&
           std::all_of(statuses_.begin(), statuses_.end(),
                       [&](const auto& entry) { return entry.second.newest_frame.seq >= seq; });
  });
  return statuses_;
}

}  // namespace sprout
