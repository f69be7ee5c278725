#include "common/app/live.h"

#include <exception>
#include <utility>

#include "common/app/frame_assembler.h"
#include "common/app/stage_monitor.h"
#include "common/app/status_reporter.h"
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

DisparityEncoding EncodingOf(const BusConfig& config) {
  return config.disparity_encoding() == BusConfig::DELTA_ZSTD ? DisparityEncoding::kDeltaZstd
                                                              : DisparityEncoding::kRawInt16;
}

void Answer(const Arrival& arrival, Plug& plug, DisparityEncoding encoding, Publisher& publisher,
            StageMonitor& monitor) {
  const FrameId& id = arrival.frame.id;
  try {
    const Outcome outcome = plug.Process(arrival.frame);
    for (const Output& output : outcome.outputs) {
      const std::string_view channel = ChannelOf(output.part);
      if (!publisher.Publish(channel, EncodePart(id, output.part, output.value, encoding))) {
        monitor.Failure(std::string(channel) + ": could not be published");
      }
    }
    monitor.FrameOut(id, arrival.when, outcome.degenerate);
  } catch (const std::exception& e) {  // a frame may fail, the stage goes on
    monitor.FrameFailed(id, e.what());
  }
}

}  // namespace

void RunLive(const ServiceContext& context, Plug& plug) {
  const DisparityEncoding encoding = EncodingOf(context.config.bus());
  StageMonitor monitor(context.stage, Digest(ConfigText(context.config)));
  FrameAssembler assembler(plug.Inputs(), monitor);
  Mailbox<Arrival> mailbox;
  Publisher publisher(context.lcm_url, context.prefix);
  const Receiver receiver(context.lcm_url, context.prefix, assembler.channels(),
                          [&](std::string_view channel, std::span<const uint8_t> bytes) {
                            for (Frame& frame : assembler.Add(channel, bytes)) {
                              const auto now = StageMonitor::Clock::now();
                              monitor.FrameIn(mailbox.Put({std::move(frame), now}));
                            }
                          });
  const StatusReporter reporter(context, monitor);
  while (const std::optional<Arrival> arrival = mailbox.Take(context.stop)) {
    Answer(*arrival, plug, encoding, publisher, monitor);
  }
}

}  // namespace sprout
