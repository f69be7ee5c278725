#include "common/app/live.h"

#include <utility>
#include <vector>

#include "common/app/answer.h"
#include "common/app/frame_assembler.h"
#include "common/app/silence_watch.h"
#include "common/app/stage_monitor.h"
#include "common/app/status_reporter.h"
#include "common/app/twin_watch.h"
#include "common/bus/channels.h"
#include "common/bus/mailbox.h"
#include "common/bus/publisher.h"
#include "common/bus/receiver.h"
#include "common/core/digest.h"
#include "common/messages/codec.h"

namespace sprout {
namespace {

struct Arrival {
  Frame frame;
  StageMonitor::Clock::time_point when;
};

void Publish(const Arrival& arrival, const Answer& answer, Publisher& publisher,
             StageMonitor& monitor) {
  for (const Answer::Message& message : answer.messages) {
    if (publisher.Publish(message.channel, message.bytes)) continue;
    return monitor.FrameFailed(arrival.frame.id,
                               std::string(message.channel) + ": could not be published");
  }
  monitor.SetTofOffset(answer.tof_offset);
  monitor.FrameOut(arrival.frame.id, arrival.when, answer.degenerate, answer.tof_coverage);
}

void OnStatus(std::span<const uint8_t> bytes, StageMonitor& monitor, TwinWatch& twins) {
  const Result<StageStatus> status = DecodeStatus(bytes);
  status ? twins.Heard(*status) : monitor.BadMessage(kStatusChannel, status.error().text);
}

}  // namespace

void RunLive(const ServiceContext& context, Plug& plug) {
  const DisparityEncoding encoding = EncodingOf(context.config.bus());
  StageMonitor monitor(context.stage, Digest(ConfigText(context.config)));
  FrameAssembler assembler(plug.Inputs(), monitor);
  Mailbox<Arrival> mailbox;
  Publisher publisher(context.lcm_url, context.prefix);
  TwinWatch twins(monitor);
  SilenceWatch silence(context, assembler.channels(), monitor);
  std::vector<std::string_view> channels = assembler.channels();
  channels.push_back(kStatusChannel);
  const Receiver receiver(
      context.lcm_url, context.prefix, channels,
      [&](std::string_view channel, std::span<const uint8_t> bytes) {
        if (channel == kStatusChannel) return OnStatus(bytes, monitor, twins);
        silence.Heard(channel);
        for (Frame& frame : assembler.Add(channel, bytes)) {
          silence.HeardFrame();
          const auto now = StageMonitor::Clock::now();
          monitor.FrameIn(mailbox.Put({std::move(frame), now}));
        }
      },
      [&](std::string_view channel) { monitor.MessageDropped(channel); });
  const StatusReporter reporter(context, monitor);
  while (const std::optional<Arrival> arrival = mailbox.Take(context.stop)) {
    const std::optional<Answer> answer = MakeAnswer(arrival->frame, plug, encoding, monitor);
    if (answer) Publish(*arrival, *answer, publisher, monitor);
  }
}

}  // namespace sprout
