#include "services/capture/capture_loop.h"

#include <fmt/core.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <set>
#include <span>
#include <stop_token>
#include <string_view>
#include <thread>
#include <utility>

#include "common/app/compute.h"
#include "common/app/log.h"
#include "common/app/log_limiter.h"
#include "common/app/stage_monitor.h"
#include "common/app/status_reporter.h"
#include "common/app/supervision.h"
#include "common/bus/channels.h"
#include "common/bus/mailbox.h"
#include "common/bus/publisher.h"
#include "common/bus/receiver.h"
#include "common/core/digest.h"
#include "common/core/joined.h"
#include "common/messages/codec.h"
#include "services/capture/answer_tracker.h"
#include "services/capture/capture_feed.h"
#include "services/capture/image_encoder.h"
#include "services/capture/rig_keeper.h"
#include "services/capture/ros2/ros_feed.h"

namespace sprout::capture {
namespace {

std::shared_ptr<CurrentRig> Required(std::shared_ptr<CurrentRig> current,
                                     const CaptureConfig& config) {
  if (current) return current;
  throw ConfigError("self_calibrate.mode = APPLY: capture.source = " + config.source() +
                    " is not rectified here; allowed: genicam:, opencv:, v4l2: and log: with "
                    "?rig=FILE, without --raw");
}

// Listens to SPROUT_RIG_CHANGE, and lets a RigKeeper correct the calibration, on a thread of its
// own with low priority, so that no frame waits.
class RigUpdates {
 public:
  // @param current  null when the source is not rectified here.
  // @param monitor  is told of every change; must outlive this.
  // @throws ConfigError as RigKeeper, and when there is nothing that could be changed; BusError.
  RigUpdates(const ServiceContext& context, std::shared_ptr<CurrentRig> current,
             StageMonitor& monitor)
      : monitor_(monitor),
        keeper_(context.config.self_calibrate(),
                Required(std::move(current), context.config.capture())),
        worker_([this](const std::stop_token& stop) { Work(stop); }),
        receiver_(
            context.lcm_url, context.prefix, {kRigChangeChannel},
            [this](std::string_view, std::span<const uint8_t> bytes) { OnMessage(bytes); },
            [this](std::string_view channel) { monitor_.MessageDropped(channel); }) {}

 private:
  void OnMessage(std::span<const uint8_t> bytes) {
    Result<RigChange> change = DecodeRigChange(bytes);
    if (!change) return monitor_.BadMessage(kRigChangeChannel, change.error().text);
    changes_.Put(*std::move(change));
  }

  void Work(const std::stop_token& stop) {
    LowerPriority();
    while (const std::optional<RigChange> change = changes_.Take(stop)) {
      try {
        const RigKeeper::Outcome outcome = keeper_.Consider(*change, RigKeeper::Clock::now());
        if (!outcome.text.empty()) monitor_.Warn(outcome.text);
      } catch (const std::exception& e) {  // out of memory
        monitor_.Failure(std::string("the calibration is not changed: ") + e.what());
      }
    }
  }

  StageMonitor& monitor_;
  RigKeeper keeper_;
  Mailbox<RigChange> changes_;
  std::jthread worker_;
  Receiver receiver_;  // last: stops before the rest is destroyed
};

using Clock = StageMonitor::Clock;

constexpr std::chrono::seconds kCalibrationPeriod{1};

// Time between the calibration and the first frame for the stages of --wait-for: touching the
// memory of a frame of 8 MP takes 70 ms in one process, beside three others on two cores twice
// that.
constexpr std::chrono::milliseconds kPreparation{200};

Clock::duration Seconds(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

// Cameras have their own rate, and a log says when its frames were taken; datasets go at the rate
// of the configuration, which the others follow only when it is asked for by a flag. With
// --lockstep alone answers set its pace.
Pace PaceOf(const CaptureConfig& config, const CaptureOptions& options, const CaptureFeed& feed) {
  if (feed.timing() == Timing::kAsked || options.rate_is_asked_for) {
    return Pace::AtRate(config.rate_hz());
  }
  const bool at_once = options.lockstep || feed.timing() == Timing::kLive;
  return at_once ? Pace::AtRate(0) : Pace::AsRecorded();
}

class Capture {
 public:
  // @param reporter  is made here if the source did not have to be waited for.
  Capture(const ServiceContext& context, const CaptureOptions& options, StageMonitor& monitor,
          Watchdog& watchdog, std::unique_ptr<CaptureFeed> feed,
          std::optional<StatusReporter>& reporter)
      : options_(options),
        stop_(context.stop),
        monitor_(monitor),
        watchdog_(watchdog),
        feed_(std::move(feed)),
        pace_(PaceOf(context.config.capture(), options, *feed_)),
        publisher_(context.lcm_url, context.prefix),
        answers_(context, monitor_, options.wait_for, options.lockstep.has_value()),
        source_(context.config.capture().source()),
        rate_hz_(context.config.capture().rate_hz()) {
    if (!reporter) reporter.emplace(context, monitor_);
    if (context.config.capture().image_encoding() != CaptureConfig::RAW) {
      encoder_.emplace(context.config.capture());
    }
    if (context.config.self_calibrate().mode() == SelfCalibrateConfig::APPLY) {
      rig_updates_.emplace(context, feed_->current_rig(), monitor_);
    }
  }

  int Run() {
    if (!WaitForStages()) return stop_.stop_requested() ? 0 : 1;
    NotifyReady();
    PublishCalibration();
    if (!options_.wait_for.empty()) WaitUntil(Clock::now() + kPreparation);
    const auto started = Clock::now();
    pace_.Start(started);
    while (!stop_.stop_requested() && sent_ != options_.frames) {
      if (!SendNext()) break;
    }
    WaitForRoom(0);
    Report(Clock::now() - started);
    if (stop_.stop_requested()) return 0;
    if (sent_ == 0) return ReportNoFrame();
    if (monitor_.Snapshot().frames_out == 0) return 1;
    return feed_->lacks_something() ? 1 : 0;
  }

 private:
  // A frame on its way through the graph.
  struct InFlight {
    CaptureMessages frame;
    Clock::time_point sent;
    bool is_overtaken = false;
  };

  // False when the feed has ended.
  bool SendNext() {
    WaitUntil(pace_.DueBeforeTaking());
    if (options_.lockstep) WaitForRoom(static_cast<size_t>(*options_.lockstep) - 1);
    if (stop_.stop_requested()) return true;
    const auto arrived = Clock::now();
    if (!options_.lockstep && pace_.IsLate(arrived)) WarnLate(arrived);
    pace_.Take(arrived);
    std::optional<CaptureMessages> frame = feed_->Next(stop_);
    if (!frame) return false;
    if (encoder_) encoder_->Encode(*frame);
    WaitUntil(pace_.DueBeforeSending(frame->id, Clock::now()));
    if (!stop_.stop_requested()) Send(std::move(*frame), arrived);
    watchdog_.FrameDone();
    return true;
  }

  // Says that frames are late, at most once every ten seconds.
  void WarnLate(Clock::time_point now) {
    ++late_;
    if (now < next_late_) return;
    const StageStatus status = monitor_.Snapshot();
    monitor_.Warn(fmt::format(
        "the rate of {} Hz is not reached: {} of {} frames came late, {:.2g} frames a second now",
        rate_hz_, late_, status.frames_in, status.rate_hz));
    next_late_ = now + std::chrono::seconds(10);
  }

  void Report(Clock::duration time) const {
    if (options_.frames && sent_ < *options_.frames && !stop_.stop_requested()) {
      LogLine(LogLevel::kWarning, "the source has {} of {} frames; --loop starts it again", sent_,
              *options_.frames);
    }
    const StageStatus status = monitor_.Snapshot();
    if (status.frames_incomplete > 0 || status.bad_messages > 0) {
      LogLine(LogLevel::kWarning,
              "{} frames were not sent because a message is missing, or a SPROUT_RIG with their "
              "rig_id; {} messages were bad",
              status.frames_incomplete, status.bad_messages);
    }
    LogLine(LogLevel::kInfo,
            "sent {} frames in {:.2f} s, {} again without an answer; {} could not be sent",
            status.frames_out, std::chrono::duration<double>(time).count(), status.frames_resent,
            status.frames_failed);
  }

  // The exit code.
  int ReportNoFrame() const {
    const std::string why = monitor_.Snapshot().last_error;
    LogLine(LogLevel::kError, "capture.source = {}: it gave no frame{}", source_,
            why.empty() ? "" : " (" + why + ")");
    return 1;
  }

  bool WaitForStages() {
    const auto missing =
        answers_.WaitForStages(Clock::now() + Seconds(options_.wait_timeout_s), stop_);
    const std::set<std::string> reported = answers_.reported();
    const std::string others =
        reported.empty() ? "" : "those of " + Joined(", ", reported) + " came; ";
    for (const std::string& stage : missing) {
      if (!stop_.stop_requested()) {
        LogLine(LogLevel::kError,
                "no status from stage '{}' in {} s; {}is it running on this LCM URL and prefix?",
                stage, options_.wait_timeout_s, others);
      }
    }
    return missing.empty();
  }

  // Sleeps, but keeps sending the calibration.
  void WaitUntil(Clock::time_point due) {
    while (!stop_.stop_requested() && Clock::now() < due) {
      watchdog_.Idle();
      PublishCalibrationWhenDue();
      std::this_thread::sleep_until(std::min(due, Clock::now() + std::chrono::milliseconds(50)));
    }
  }

  // Waits until at most `count` frames are without an answer; sends those again that wait too long,
  // or for an answer that will not come.
  void WaitForRoom(size_t count) {
    while (!stop_.stop_requested() && in_flight_.size() > count) {
      watchdog_.Idle();
      answers_.WaitForRoom(count, Clock::now() + std::chrono::milliseconds(200), stop_);
      RemoveAnswered();
      PublishCalibrationWhenDue();
      SendOverdueAgain();
    }
  }

  // Frames are answered in the order in which they were sent. One that was overtaken was lost, or
  // skipped: of several frames that wait for a stage only the newest is kept.
  void RemoveAnswered() {
    const auto is_answered = [&](const InFlight& one) { return answers_.IsAnswered(one.frame.id); };
    const auto newest = std::find_if(in_flight_.rbegin(), in_flight_.rend(), is_answered);
    std::for_each(newest, in_flight_.rend(), [](InFlight& one) { one.is_overtaken = true; });
    std::erase_if(in_flight_, is_answered);
  }

  void SendOverdueAgain() {
    const auto oldest = Clock::now() - Seconds(options_.lockstep_timeout_s);
    auto again = std::stable_partition(
        in_flight_.begin(), in_flight_.end(),
        [&](const InFlight& one) { return one.sent > oldest && !one.is_overtaken; });
    for (; again != in_flight_.end(); ++again) {
      monitor_.FrameResent(again->frame.id);
      PublishCalibration();
      static_cast<void>(Publish(again->frame));
      again->sent = Clock::now();
      again->is_overtaken = false;
    }
  }

  void Send(CaptureMessages frame, Clock::time_point arrived) {
    const FrameId id = frame.id;
    ++sent_;
    monitor_.FrameIn(/*skipped=*/false);
    PublishCalibrationWhenDue();
    if (options_.lockstep) answers_.Expect(id);
    const bool published = Publish(frame);
    if (options_.lockstep) in_flight_.push_back({std::move(frame), Clock::now()});
    if (published) monitor_.FrameOut(id, arrived, /*degenerate=*/"");
  }

  std::string Channel(Part part) const {
    return std::string(options_.raw ? kRawPrefix : "") + std::string(ChannelOf(part));
  }

  // False, and counted, when not all of it could be sent.
  bool Publish(const CaptureMessages& frame) {
    for (const auto& [part, bytes] : frame.messages) {
      if (publisher_.Publish(Channel(part), bytes)) continue;
      monitor_.FrameNotSent(frame.id, publisher_.failure());
      return false;
    }
    return true;
  }

  void PublishCalibrationWhenDue() {
    if (Clock::now() >= next_calibration_) PublishCalibration();
  }

  void PublishCalibration() {
    const std::vector<uint8_t> calibration = feed_->Calibration();
    if (!calibration.empty() && !publisher_.Publish(ChannelOf(Part::kRig), calibration)) {
      monitor_.NotSent(publisher_.failure());
    }
    next_calibration_ = Clock::now() + kCalibrationPeriod;
  }

  const CaptureOptions& options_;
  std::stop_token stop_;
  StageMonitor& monitor_;
  Watchdog& watchdog_;
  std::unique_ptr<CaptureFeed> feed_;
  Pace pace_;
  Publisher publisher_;
  AnswerTracker answers_;
  std::optional<RigUpdates> rig_updates_;
  std::optional<ImageEncoder> encoder_;
  int64_t sent_ = 0;
  std::string source_;
  double rate_hz_;
  int64_t late_ = 0;  // frames that were taken more than an interval too late
  Clock::time_point next_late_ = Clock::now() + std::chrono::seconds(2);  // rates need some frames
  Clock::time_point next_calibration_{};
  std::vector<InFlight> in_flight_;  // in the order in which they were sent
};

}  // namespace

int RunCapture(const ServiceContext& context, const CaptureOptions& options) {
  StageMonitor monitor(context.stage, Digest(ConfigText(context.config)));
  Watchdog watchdog;
  const std::shared_ptr<void> warnings = TakeRosWarnings(monitor);
  std::optional<StatusReporter> reporter;
  const auto wait = [&](const std::string& reason) {
    watchdog.Idle();
    if (!reason.empty()) monitor.Warn(reason);
    if (!reporter) reporter.emplace(context, monitor);  // the source may wait to be opened, too
  };
  std::unique_ptr<CaptureFeed> feed = OpenCaptureFeed(
      context.config.capture(),
      {.loop = options.loop, .raw = options.raw, .waiting = wait, .stop = context.stop}, monitor);
  if (!feed) return 0;
  return Capture(context, options, monitor, watchdog, std::move(feed), reporter).Run();
}

}  // namespace sprout::capture
