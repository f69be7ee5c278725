#include "services/capture/answer_tracker.h"

#include <algorithm>

#include "common/bus/channels.h"
#include "common/messages/codec.h"

namespace sprout::capture {
namespace {

std::vector<std::string_view> Channels(bool disparities) {
  if (disparities) return {kStatusChannel, ChannelOf(Part::kDisparity)};
  return {kStatusChannel};
}

}  // namespace

AnswerTracker::AnswerTracker(const ServiceContext& context, StageMonitor& monitor,
                             const std::vector<std::string>& stages, bool disparities)
    : monitor_(monitor),
      duplicates_(monitor),
      silent_(stages.begin(), stages.end()),
      receiver_(
          context.lcm_url, context.prefix, Channels(disparities),
          [this](std::string_view channel, std::span<const uint8_t> bytes) {
            OnMessage(channel, bytes);
          },
          [this](std::string_view channel) { monitor_.MessageDropped(channel); }) {}

void AnswerTracker::OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
  try {
    channel == kStatusChannel ? OnStatus(bytes) : OnDisparity(bytes);
  } catch (const std::exception& e) {  // out of memory: must not cross LCM's C frames
    monitor_.BadMessage(channel, e.what());
  }
  changed_.notify_all();
}

void AnswerTracker::OnStatus(std::span<const uint8_t> bytes) {
  const Result<StageStatus> status = DecodeStatus(bytes);
  if (!status) return monitor_.BadMessage(kStatusChannel, status.error().text);
  duplicates_.Heard(*status);
  const std::lock_guard lock(mutex_);
  silent_.erase(status->stage);
}

void AnswerTracker::OnDisparity(std::span<const uint8_t> bytes) {
  const Result<DecodedPart> part = DecodePart(Part::kDisparity, bytes);
  if (!part) return monitor_.BadMessage(ChannelOf(Part::kDisparity), part.error().text);
  const std::lock_guard lock(mutex_);
  std::erase(missing_, part->id);
}

std::set<std::string> AnswerTracker::WaitForStages(Deadline deadline, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, deadline, [&] { return silent_.empty(); });
  return silent_;
}

void AnswerTracker::Expect(const FrameId& id) {
  const std::lock_guard lock(mutex_);
  missing_.push_back(id);
}

bool AnswerTracker::IsAnswered(const FrameId& id) {
  const std::lock_guard lock(mutex_);
  return std::find(missing_.begin(), missing_.end(), id) == missing_.end();
}

void AnswerTracker::WaitForRoom(size_t count, Deadline deadline, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, deadline, [&] { return missing_.size() <= count; });
}

}  // namespace sprout::capture
