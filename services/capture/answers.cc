#include "services/capture/answers.h"

#include <algorithm>

#include "common/bus/channels.h"
#include "common/messages/codec.h"

namespace sprout {

Answers::Answers(const ServiceContext& context, StageMonitor& monitor)
    : monitor_(monitor),
      receiver_(context.lcm_url, context.prefix, {kStatusChannel, ChannelOf(Part::kDisparity)},
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
      answered_.insert(part->id.seq);
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

int64_t Answers::WaitForAny(const std::vector<int64_t>& seqs, Deadline deadline,
                            const std::stop_token& stop) {
  int64_t found = -1;
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, stop, deadline, [&] {
    const auto answered = std::find_if(seqs.begin(), seqs.end(),
                                       [&](int64_t seq) { return answered_.contains(seq); });
    if (answered == seqs.end()) return false;
    found = *answered;
    return true;
  });
  answered_.erase(found);
  return found;
}

}  // namespace sprout
