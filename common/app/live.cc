#include "common/app/live.h"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/app/answer.h"
#include "common/app/compute.h"
#include "common/app/frame_assembler.h"
#include "common/app/frames_under_way.h"
#include "common/app/log.h"
#include "common/app/silence_watch.h"
#include "common/app/status_reporter.h"
#include "common/app/supervision.h"
#include "common/bus/channels.h"
#include "common/bus/mailbox.h"
#include "common/bus/publisher.h"
#include "common/bus/receiver.h"
#include "common/core/digest.h"
#include "common/messages/codec.h"
#include "common/messages/message_type.h"

namespace sprout {
namespace {

// The first stage of the chain, whatever program it is, and what the next one and the last one
// answer with.
constexpr std::string_view kFirstStage = "refine";
constexpr Part kNextAnswer = Part::kPrior;
constexpr Part kLastAnswer = Part::kDisparity;

struct Arrival {
  Frame frame;
  StageMonitor::Clock::time_point when;
};

// What the first frame would otherwise wait for, done while the stage waits for it: the
// calibration, which capture sends before, says how large the frames will be.
class Preparation {
 public:
  explicit Preparation(size_t stages) : stages_(stages) {}

  // Called by the receiver's thread. A calibration that cannot be read is counted where it is
  // needed.
  void HeardCalibration(std::span<const uint8_t> bytes) {
    if (is_over_) return;
    const Result<DecodedPart> part = DecodePart(Part::kRig, bytes);
    if (part) pixels_ = std::get<Rig>(part->value).pair.size().area();
  }

  // Touches the memory of a frame once, on the stage's thread, while there is no frame.
  void Continue() {
    const int64_t pixels = is_over_ ? 0 : pixels_.load();
    if (pixels == 0) return;
    // The maps that a stage has at the same time: 16 bytes a pixel of two images in colour and
    // grey with what they are decoded from, and as many of results and what is between.
    constexpr int64_t kBytes = 32;
    constexpr int64_t kMaxPixels = 8'000'000;  // a wrong calibration must not take all memory
    is_over_ = true;
    try {
      TouchMemory(stages_ * static_cast<size_t>(kBytes * std::min(pixels, kMaxPixels)));
    } catch (const std::bad_alloc&) {  // it only saves the first frame some time
    }
  }

  void FrameCame() { is_over_ = true; }

  // A calibration is followed by its first frame soon.
  std::chrono::milliseconds Period() const {
    return is_over_ ? Watchdog::kIdlePeriod : std::chrono::milliseconds(20);
  }

 private:
  size_t stages_;
  std::atomic<int64_t> pixels_ = 0;
  std::atomic<bool> is_over_ = false;
};

void Publish(const Arrival& arrival, const Answer& answer, Publisher& publisher,
             StageMonitor& monitor) {
  for (const Answer::Message& message : answer.messages) {
    if (publisher.Publish(message.channel, message.bytes)) continue;
    return monitor.FrameNotSent(arrival.frame.id, publisher.failure());
  }
  monitor.SetRig(arrival.frame.id.rig_id);
  monitor.SetTofOffset(answer.tof_offset);
  monitor.SetFinding(answer.finding);
  monitor.FrameOut(arrival.frame.id, arrival.when, answer.degenerate, answer.tof_coverage);
}

// What a stage hears: its inputs, joined to frames, the statuses of all stages, and, if it is the
// first stage, how far the later ones are. Messages come on the receiver's thread, frames go out on
// the stage's own.
class LiveInput {
 public:
  LiveInput(const ServiceContext& context, const StageAdapter& adapter, size_t steps,
            StageMonitor& monitor)
      : is_first_(context.stage == kFirstStage),
        monitor_(monitor),
        assembler_(adapter.Inputs(), monitor, FrameJoiner::kDefaultMaxPending,
                   adapter.OptionalInputs()),
        takes_calibration_(std::ranges::count(assembler_.channels(), ChannelOf(Part::kRig)) > 0),
        duplicates_(monitor),
        silence_(context, assembler_.channels(), monitor),
        preparation_(std::max<size_t>(1, steps)) {
    receiver_.emplace(
        context.lcm_url, context.prefix, Channels(),
        [this](std::string_view channel, const MessageBytes& bytes) { Hear(channel, bytes); },
        [this](std::string_view channel) { monitor_.MessageDropped(channel); },
        Receiver::kMaxQueuedBytes, LaterAnswers());
  }

  // The next frame; nothing if there is none within a moment, or no room for one behind this stage.
  std::optional<Arrival> Take(const std::stop_token& stop) {
    if (!under_way_.WaitForRoom(Watchdog::kIdlePeriod, stop)) return std::nullopt;
    std::optional<Arrival> arrival = mailbox_.TakeWithin(preparation_.Period(), stop);
    if (!arrival) {
      preparation_.Continue();
      return std::nullopt;
    }
    preparation_.FrameCame();
    TakeNewest(*arrival, stop);
    return arrival;
  }

  // This stage answered a frame of its own.
  void Answered(const FrameId& id, StageMonitor::Clock::duration worked) {
    if (is_first_) under_way_.Sent(id, worked);
  }

  // Stops receiving, and counts the frames that are left as skipped.
  void Finish() {
    receiver_.reset();
    if (mailbox_.Clear()) monitor_.FrameSkipped();
    for ([[maybe_unused]] const Frame& frame : assembler_.Finish()) {
      monitor_.FrameIn(/*skipped=*/true);
    }
  }

 private:
  std::vector<std::string_view> Channels() const {
    std::vector<std::string_view> channels = assembler_.channels();
    channels.push_back(kStatusChannel);
    if (!takes_calibration_) channels.push_back(ChannelOf(Part::kRig));
    return channels;
  }

  // Of which only the frame is asked.
  std::vector<std::string_view> LaterAnswers() const {
    if (!is_first_) return {};
    return {ChannelOf(kNextAnswer), ChannelOf(kLastAnswer)};
  }

  void Hear(std::string_view channel, const MessageBytes& bytes) {
    if (channel == kStatusChannel) return HearStatus(bytes);
    for (const Part part : {kNextAnswer, kLastAnswer}) {
      if (is_first_ && channel == ChannelOf(part)) return HearLaterAnswer(part, bytes);
    }
    if (channel == ChannelOf(Part::kRig)) {
      preparation_.HeardCalibration(bytes);
      if (!takes_calibration_) return;
    }
    silence_.Heard(channel);
    for (Frame& frame : assembler_.Add(channel, bytes, bytes.memory)) {
      silence_.HeardFrame();
      const auto now = StageMonitor::Clock::now();
      monitor_.FrameIn(mailbox_.Put({std::move(frame), now}));
    }
  }

  void HearStatus(std::span<const uint8_t> bytes) {
    const Result<StageStatus> status = DecodeStatus(bytes);
    status ? duplicates_.Heard(*status) : monitor_.BadMessage(kStatusChannel, status.error().text);
  }

  // An answer of a later stage, which only says how far a frame is. What cannot be read is counted
  // by those who use it.
  void HearLaterAnswer(Part part, std::span<const uint8_t> bytes) {
    if (TypeOf(bytes) != TypeOf(part)) return;
    const Result<FrameId> id = DecodeFrameId(bytes);
    if (id) part == kLastAnswer ? under_way_.Answered(*id) : under_way_.Passed(*id);
  }

  // What came while this process was stopped is old, and the kernel keeps its beginning alone where
  // it is more than fits: waits for a frame that came after it, or, if none does, takes the newest.
  void TakeNewest(Arrival& arrival, const std::stop_token& stop) {
    constexpr std::chrono::milliseconds kPatience{250};
    bool is_behind = receiver_->IsBehind();
    auto until = StageMonitor::Clock::now();
    while (!stop.stop_requested() && (is_behind || StageMonitor::Clock::now() < until)) {
      if (is_behind) until = StageMonitor::Clock::now() + kPatience;
      if (auto newer = mailbox_.TakeWithin(std::chrono::milliseconds(1), stop)) {
        arrival = *std::move(newer);
        monitor_.FrameSkipped();
        if (!is_behind) return;
      }
      is_behind = receiver_->IsBehind();
    }
  }

  bool is_first_;
  StageMonitor& monitor_;
  FrameAssembler assembler_;
  bool takes_calibration_;  // as an input
  DuplicateWatch duplicates_;
  SilenceWatch silence_;
  Mailbox<Arrival> mailbox_;
  FramesUnderWay under_way_;
  Preparation preparation_;
  std::optional<Receiver> receiver_;  // last: it calls Hear()
};

// The frames of a process; losses are named only where there are some.
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
  monitor.SetVersion(context.version);
  Publisher publisher(context.lcm_url, context.prefix);
  LiveInput input(context, adapter, steps.size(), monitor);
  // Behind the input: whoever waits for a status may send at once.
  const StatusReporter reporter(context, monitor);
  std::list<StatusReporter> step_reporters;
  for (StageMonitor& step : steps) step_reporters.emplace_back(context, step);
  NotifyReady();
  Watchdog watchdog;
  while (!context.stop.stop_requested()) {
    watchdog.Idle();
    const std::optional<Arrival> arrival = input.Take(context.stop);
    watchdog.Idle();
    if (!arrival) continue;
    const FrameId& id = arrival->frame.id;
    const auto begun = StageMonitor::Clock::now();
    const std::chrono::duration<double, std::milli> waited = begun - arrival->when;
    LogLine(LogLevel::kDebug, "frame {}: waited {:.1f} ms", id.seq, waited.count());
    if (const auto answer = MakeAnswer(arrival->frame, adapter, encoding, monitor)) {
      input.Answered(id, StageMonitor::Clock::now() - begun);
      Publish(*arrival, *answer, publisher, monitor);
    }
    watchdog.FrameDone();
  }
  input.Finish();
  LogLine(LogLevel::kInfo, CountsText(monitor.Snapshot()));
}

}  // namespace sprout
