#include "services/selfcalibrate/frame_taker.h"

#include <vector>

#include "common/app/supervision.h"
#include "common/bus/mailbox.h"
#include "common/bus/receiver.h"

namespace sprout::selfcalibrate {

std::optional<Frame> FrameTaker::Take(const std::function<void()>& waiting) {
  joiner_.DropPending();
  Mailbox<Frame> mailbox;
  std::vector<std::string_view> channels;
  for (const Part part : kParts) channels.push_back(ChannelOf(part));
  const Receiver receiver(
      context_.lcm_url, context_.prefix, channels,
      [&](std::string_view channel, std::span<const uint8_t> bytes) {
        Result<std::vector<Frame>> frames = joiner_.AddMessage(*PartOf(channel), bytes);
        if (!frames) return monitor_.BadMessage(channel, frames.error().text);
        for (Frame& frame : *frames) mailbox.Put(std::move(frame));
      },
      [&](std::string_view channel) { monitor_.MessageDropped(channel); });
  while (!context_.stop.stop_requested()) {
    waiting();
    if (std::optional<Frame> frame = mailbox.TakeWithin(Watchdog::kIdlePeriod, context_.stop)) {
      return frame;
    }
  }
  return std::nullopt;
}

}  // namespace sprout::selfcalibrate
