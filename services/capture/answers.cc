#include "services/capture/answers.h"

#include <algorithm>

#include "common/bus/channels.h"
#include "common/messages/codec.h"

namespace sprout {
namespace {

std::vector<std::string_view> Channels(bool disparities) {
  if (disparities) return {kStatusChannel, ChannelOf(Part::kDisparity)};
  return {kStatusChannel};
}

}  // namespace

Answers::Answers(const ServiceContext& context, StageMonitor& monitor, bool disparities)
    : monitor_(monitor),
      receiver_(context.lcm_url, context.prefix, Channels(disparities),
                [this](std::string_view channel, std::span<const uint8_t> bytes) {
                  OnMessage(channel, bytes);
                }) {}

void Answers::OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
  try {
    if (channel == kStatusChannel) {
      const Result<StageStatus> status = DecodeStatus(bytes);
      if (!status) return monitor_.BadMessage(channel, status.error().text);
      const std::lock_guard lock(mutex_);
      stages_.insert(status->stage);
    } else {
      const Result<DecodedPart> part = DecodePart(Part::kDisparity, bytes);
      if (!part) return monitor_.BadMessage(channel, part.error().text);
      const std::lock_guard lock(mutex_);
      missing_.erase(part->id.seq);
    }
  } catch (const std::exception& e) {  // out of memory: must not cross LCM's C frames
    monitor_.BadMessage(channel, e.what());
  }
  changed_.notify_all();
}

std::vector<std::string> Answers::WaitForStages(const std::vector<std::string>& stages,
                                                Deadline deadline, const std::stop_token& stop) {
  std::vector<std::string> missing;
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, deadline, [&] {
    missing.clear();
    std::copy_if(stages.begin(), stages.end(), std::back_inserter(missing),
                 [&](const std::string& stage) { return !stages_.contains(stage); });
    return missing.empty();
  });
  return missing;
}

void Answers::Expect(int64_t seq) {
  const std::lock_guard lock(mutex_);
  missing_.insert(seq);
}

bool Answers::IsAnswered(int64_t seq) {
  const std::lock_guard lock(mutex_);
  return !missing_.contains(seq);
}

void Answers::WaitForRoom(size_t count, Deadline deadline, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, deadline, [&] { return missing_.size() <= count; });
}

}  // namespace sprout
