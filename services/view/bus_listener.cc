#include "services/view/bus_listener.h"

#include <exception>
#include <utility>

#include "common/bus/channels.h"
#include "common/messages/codec.h"

namespace sprout::view {

BusListener::BusListener(const ServiceContext& context, FrameRing& ring, StatusHistory& history,
                         StageMonitor& monitor, std::function<void()> changed)
    : ring_(ring),
      history_(history),
      monitor_(monitor),
      changed_(std::move(changed)),
      // These two channels are needed to see anything; all others may be missing.
      silence_(context, {ChannelOf(Part::kLeft), ChannelOf(Part::kDisparity)}, monitor),
      duplicates_(monitor),
      receiver_(
          context.lcm_url, context.prefix, AllChannels(),
          [this](std::string_view channel, std::span<const uint8_t> bytes) {
            OnMessage(channel, bytes);
          },
          [this](std::string_view channel) { monitor_.MessageDropped(channel); }) {}

void BusListener::OnMessage(std::string_view channel, std::span<const uint8_t> bytes) {
  const auto now = StageMonitor::Clock::now();
  try {
    if (channel == kStatusChannel) OnStatus(bytes, now);
    silence_.Heard(channel);
    const Result<bool> changed = ring_.Add(channel, bytes, NowUtime(), now);
    if (!changed) return monitor_.BadMessage(channel, changed.error().text);
    if (*changed) OnNewest(now);
  } catch (const std::exception& e) {  // out of memory
    monitor_.BadMessage(channel, e.what());
  }
}

void BusListener::OnStatus(std::span<const uint8_t> bytes, StageMonitor::Clock::time_point now) {
  const Result<StageStatus> status = DecodeStatus(bytes);
  if (!status) return monitor_.BadMessage(kStatusChannel, status.error().text);
  history_.Add(*status, NowUtime(), now);
  duplicates_.Heard(*status);
}

void BusListener::OnNewest(StageMonitor::Clock::time_point now) {
  const StoredFramePtr newest = ring_.Newest();
  if (newest_key_ != newest->key) {
    newest_key_ = newest->key;
    gaps_.Add(newest->id);
    monitor_.SetJoinerCounts(/*incomplete=*/0, gaps_.count());
    monitor_.FrameIn(/*skipped=*/false);
    monitor_.FrameOut(newest->id, now, /*degenerate=*/"");
  }
  if (newest->Has(Part::kLeft) && newest->Has(Part::kDisparity)) silence_.HeardFrame();
  changed_();
}

}  // namespace sprout::view
