#include "services/snapshot/graph_listener.h"

#include <algorithm>
#include <array>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/channels.h"
#include "common/messages/codec.h"

namespace sprout::snapshot {
namespace {

// Stages whose status is kept; a graph has four. Names are free, so anybody could invent more.
constexpr size_t kMaxStages = 32;

// What a frame needs to be shown.
const PartSet kNeededParts{Part::kLeft,  Part::kRight, Part::kTof,      Part::kRig,
                           Part::kSeeds, Part::kPrior, Part::kDisparity};

// What is shown when it is there: not every grower says it.
constexpr std::array kOptionalParts{Part::kUnfilled, Part::kConfidence};

// Messages of an optional part that are kept until the rest of their frame is here.
constexpr size_t kMaxOptional = 4;

std::vector<std::string_view> WithOthers(std::vector<std::string_view> channels) {
  for (const Part part : kOptionalParts) channels.push_back(ChannelOf(part));
  channels.push_back(kStatusChannel);
  return channels;
}

}  // namespace

GraphListener::GraphListener(const ServiceContext& context, StageMonitor& monitor)
    : monitor_(monitor),
      assembler_(kNeededParts, monitor),
      receiver_(
          context.lcm_url, context.prefix, WithOthers(assembler_.channels()),
          [this](std::string_view channel, std::span<const uint8_t> bytes) {
            OnMessage(channel, bytes);
          },
          [this](std::string_view channel) { monitor_.MessageDropped(channel); }) {}

void GraphListener::OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
  if (channel == kStatusChannel) return OnStatus(bytes);
  const auto arrived = StageMonitor::Clock::now();
  {
    const std::lock_guard lock(mutex_);
    heard_.emplace(channel);
  }
  for (const Part part : kOptionalParts) {
    if (channel == ChannelOf(part)) return OnOptional(part, bytes);
  }
  for (Frame& frame : assembler_.Add(channel, bytes)) {
    monitor_.FrameIn(/*skipped=*/false);
    monitor_.FrameOut(frame.id, arrived, /*degenerate=*/"");
    const std::lock_guard lock(mutex_);
    seqs_.insert(frame.id.seq);
    if (taken_) continue;
    newest_ = std::move(frame);
    AddOptionals();
  }
  changed_.notify_all();
}

void GraphListener::OnOptional(Part part, std::span<const uint8_t> bytes) {
  try {
    const std::lock_guard lock(mutex_);
    Result<DecodedPart> decoded =
        DecodePart(part, bytes, newest_ ? std::optional(newest_->rig->pair.size()) : std::nullopt);
    if (!decoded) return monitor_.BadMessage(ChannelOf(part), decoded.error().text);
    std::deque<DecodedPart>& kept = optional_[part];
    kept.push_back(std::move(*decoded));
    if (kept.size() > kMaxOptional) kept.pop_front();
    AddOptionals();
  } catch (const std::exception& e) {  // out of memory: must not cross LCM's C frames
    monitor_.BadMessage(ChannelOf(part), e.what());
  }
  changed_.notify_all();
}

// Under the mutex.
void GraphListener::AddOptionals() {
  if (!newest_) return;
  for (auto& [part, kept] : optional_) {
    for (const DecodedPart& decoded : kept) {
      if (decoded.id == newest_->id) SetPart(*newest_, part, decoded.value);
    }
  }
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

std::optional<Frame> GraphListener::TakeNewest(Deadline deadline, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  taken_ = true;
  changed_.wait_until(lock, stop, deadline, [&] {
    return !newest_ || (newest_->unfilled && !newest_->confidence.empty());
  });
  return newest_;
}

std::vector<std::string> GraphListener::SilentChannels() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> silent;
  for (const std::string_view channel : assembler_.channels()) {
    if (!heard_.contains(channel)) silent.emplace_back(channel);
  }
  return silent;
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

}  // namespace sprout::snapshot
