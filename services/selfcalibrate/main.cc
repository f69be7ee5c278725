#include <glog/logging.h>

#include <chrono>
#include <functional>
#include <optional>
#include <vector>

#include "common/app/compute.h"
#include "common/app/log.h"
#include "common/app/service.h"
#include "common/app/service_context.h"
#include "common/app/silence_watch.h"
#include "common/app/stage_monitor.h"
#include "common/app/status_reporter.h"
#include "common/app/supervision.h"
#include "common/bus/channels.h"
#include "common/bus/mailbox.h"
#include "common/bus/publisher.h"
#include "common/bus/receiver.h"
#include "common/core/digest.h"
#include "common/core/frame.h"
#include "common/core/sleep.h"
#include "common/frames/frame_joiner.h"
#include "common/messages/codec.h"
#include "services/selfcalibrate/rig_watch.h"

namespace sprout::selfcalibrate {
namespace {

// Takes single frames (LEFT, RIGHT, TOF, RIG) from the running graph. Listens only while it waits
// for one: receiving every frame of 2 MP would take more time than looking at some of them.
class FrameTaker {
 public:
  // @param monitor  counts messages that are refused.
  FrameTaker(const ServiceContext& context, StageMonitor& monitor)
      : context_(context), monitor_(monitor) {}

  // The next whole frame that is captured; nothing once a stop is requested.
  // @param waiting  called at least every Watchdog::kIdlePeriod meanwhile.
  // @throws BusError when the network cannot be used.
  std::optional<Frame> Take(const std::function<void()>& waiting) {
    joiner_.DropPending();
    Mailbox<Frame> mailbox;
    std::vector<std::string_view> channels;
    for (const Part part : kParts) channels.push_back(ChannelOf(part));
    SilenceWatch silence(context_, channels, monitor_, kPatience);
    const Receiver receiver(
        context_.lcm_url, context_.prefix, channels,
        [&](std::string_view channel, std::span<const uint8_t> bytes) {
          silence.Heard(channel);
          Result<std::vector<Frame>> frames = joiner_.AddMessage(*PartOf(channel), bytes);
          if (!frames) return monitor_.BadMessage(channel, frames.error().text);
          if (!frames->empty()) silence.HeardFrame();
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

 private:
  static constexpr Part kParts[] = {Part::kLeft, Part::kRight, Part::kTof, Part::kRig};
  // Long, since the rate of the frames is not known: only one is received now and then.
  static constexpr std::chrono::seconds kPatience{15};

  const ServiceContext& context_;
  StageMonitor& monitor_;
  // Keeps the calibration, which comes once a second, from one frame to the next.
  FrameJoiner joiner_{PartSet{Part::kLeft, Part::kRight, Part::kTof, Part::kRig}};
};

using Clock = StageMonitor::Clock;

// Measures on a frame now and then, and publishes the results.
class Watcher {
 public:
  explicit Watcher(const ServiceContext& context)
      : config_(context.config.self_calibrate()),
        stop_(context.stop),
        watch_(config_),
        monitor_(context.stage, Digest(ConfigText(context.config))),
        publisher_(context.lcm_url, context.prefix),
        taker_(context, monitor_),
        reporter_(context, monitor_) {}

  void Run() {
    NotifyReady();
    auto due = Clock::now();
    while (!stop_.stop_requested()) {
      const std::optional<Frame> frame = taker_.Take([&] { watchdog_.Idle(); });
      if (!frame) return;
      Measure(*frame);
      due = std::max(Clock::now(), due + Period());
      WaitUntil(due);
    }
  }

 private:
  Clock::duration Period() const {
    return std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(config_.period_s()));
  }

  void WaitUntil(Clock::time_point due) {
    while (!stop_.stop_requested() && Clock::now() < due) {
      watchdog_.Idle();
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(due - Clock::now());
      SleepFor(std::min(left, Watchdog::kIdlePeriod), stop_);
    }
  }

  void Measure(const Frame& frame) {
    const auto arrived = Clock::now();
    monitor_.FrameIn(/*skipped=*/false);
    monitor_.SetRig(frame.id.rig_id);
    try {
      const Result<std::optional<RigChange>> seen = watch_.Add(frame);
      if (!seen) return monitor_.FrameFailed(frame.id, seen.error().text);
      std::string degenerate;
      if (*seen) PublishResult(**seen, frame.rig->pair, degenerate);
      monitor_.FrameOut(frame.id, arrived, degenerate);
    } catch (const std::exception& e) {  // out of memory
      watch_.Forget();
      monitor_.FrameFailed(frame.id, e.what());
    }
  }

  void PublishResult(const RigChange& change, const RectifiedPair& pair, std::string& degenerate) {
    if (!publisher_.Publish(kRigChangeChannel, EncodeRigChange(change))) {
      monitor_.Failure(publisher_.failure());
    }
    const std::string text = ChangeText(change, pair);
    if (change.verdict == RigChange::Verdict::kUnseen) {
      degenerate = text;
      return;
    }
    monitor_.SetTofOffset(OffsetOf(change, pair));
    const std::string ranges = watch_.curve().empty() ? "" : CurveText(watch_.curve());
    if (change.verdict == RigChange::Verdict::kRight) {
      LogLine(LogLevel::kInfo, text);
      if (!ranges.empty()) monitor_.Warn(ranges);
      return;
    }
    const bool applied = config_.mode() == SelfCalibrateConfig::APPLY;
    monitor_.Warn(text + ". " + AdviceText(applied) + (ranges.empty() ? "" : ". ") + ranges);
  }

  const SelfCalibrateConfig& config_;
  std::stop_token stop_;
  RigWatch watch_;
  StageMonitor monitor_;
  Publisher publisher_;
  FrameTaker taker_;
  Watchdog watchdog_;  // gets no FrameDone(): a frame with a result takes many times as long
  StatusReporter reporter_;
};

int Run(const ServiceContext& context) {
  if (context.config.self_calibrate().mode() == SelfCalibrateConfig::OFF) {
    LogLine(LogLevel::kInfo, "self_calibrate.mode is OFF: nothing is looked at");
    return 0;
  }
  FLAGS_minloglevel = google::GLOG_FATAL;  // no remarks of Ceres: failures are reported here
  SetThreads(1);
  LowerPriority();
  Watcher(context).Run();
  return 0;
}

int Main(int argc, char** argv) {
  Service service("selfcalibrate",
                  "Looks at a frame of the running graph now and then, and publishes by how much\n"
                  "the rig differs from its calibration: SPROUT_RIG_CHANGE. Warns of a wrong one.\n"
                  "With self_calibrate { mode: APPLY } sprout-capture puts it right.");
  return service.Run(argc, argv, Run);
}

}  // namespace

}  // namespace sprout::selfcalibrate

int main(int argc, char** argv) { return sprout::selfcalibrate::Main(argc, argv); }
