#include "common/app/live.h"

#include <fmt/core.h>

#include <list>
#include <string>
#include <utility>
#include <vector>

#include "common/app/answer.h"
#include "common/app/duplicate_watch.h"
#include "common/app/frame_assembler.h"
#include "common/app/log.h"
#include "common/app/silence_watch.h"
#include "common/app/stage_monitor.h"
#include "common/app/status_reporter.h"
#include "common/app/supervision.h"
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

void OnStatus(std::span<const uint8_t> bytes, StageMonitor& monitor, DuplicateWatch& duplicates) {
  const Result<StageStatus> status = DecodeStatus(bytes);
  status ? duplicates.Heard(*status) : monitor.BadMessage(kStatusChannel, status.error().text);
}

// What went wrong is named only where something did.
std::string CountsText(const StageStatus& status) {
  std::string text = fmt::format("{} frames in, {} out", status.frames_in, status.frames_out);
  const std::pair<int64_t, const char*> counts[] = {{status.frames_skipped, "skipped"},
                                                    {status.frames_incomplete, "incomplete"},
                                                    {status.frames_degenerate, "without a result"},
                                                    {status.frames_failed, "failed"},
                                                    {status.frames_resent, "sent again"},
                                                    {status.sequence_gaps, "left out"},
                                                    {status.bad_messages, "bad messages"}};
  for (const auto& [count, what] : counts) {
    if (count > 0) text += fmt::format(", {} {}", count, what);
  }
  return text;
}

}  // namespace

void RunLive(const ServiceContext& context, StageAdapter& adapter, std::span<StageMonitor> steps) {
  const DisparityEncoding encoding = EncodingOf(context.config.bus());
  StageMonitor monitor(context.stage, Digest(ConfigText(context.config)));
  FrameAssembler assembler(adapter.Inputs(), monitor);
  Mailbox<Arrival> mailbox;
  Publisher publisher(context.lcm_url, context.prefix);
  DuplicateWatch duplicates(monitor);
  SilenceWatch silence(context, assembler.channels(), monitor);
  std::vector<std::string_view> channels = assembler.channels();
  channels.push_back(kStatusChannel);
  const Receiver receiver(
      context.lcm_url, context.prefix, channels,
      [&](std::string_view channel, std::span<const uint8_t> bytes) {
        if (channel == kStatusChannel) return OnStatus(bytes, monitor, duplicates);
        silence.Heard(channel);
        for (Frame& frame : assembler.Add(channel, bytes)) {
          silence.HeardFrame();
          const auto now = StageMonitor::Clock::now();
          monitor.FrameIn(mailbox.Put({std::move(frame), now}));
        }
      },
      [&](std::string_view channel) { monitor.MessageDropped(channel); });
  // Behind the receiver: whoever waits for a status may send at once.
  const StatusReporter reporter(context, monitor);
  std::list<StatusReporter> step_reporters;
  for (StageMonitor& step : steps) step_reporters.emplace_back(context, step);
  NotifyReady();
  Watchdog watchdog;
  while (!context.stop.stop_requested()) {
    const auto arrival = mailbox.TakeWithin(Watchdog::kIdlePeriod, context.stop);
    watchdog.Idle();
    if (!arrival) continue;
    const std::optional<Answer> answer = MakeAnswer(arrival->frame, adapter, encoding, monitor);
    if (answer) Publish(*arrival, *answer, publisher, monitor);
    watchdog.FrameDone();
  }
  LogLine(LogLevel::kInfo, CountsText(monitor.Snapshot()));
}

}  // namespace sprout
