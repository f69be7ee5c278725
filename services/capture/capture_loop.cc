#include "services/capture/capture_loop.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <thread>

#include "common/app/stage_monitor.h"
#include "common/app/status_reporter.h"
#include "common/bus/channels.h"
#include "common/bus/publisher.h"
#include "common/core/digest.h"
#include "common/core/image.h"
#include "common/messages/codec.h"
#include "services/capture/answers.h"

namespace sprout {
namespace {

using Clock = StageMonitor::Clock;

constexpr std::chrono::seconds kRigPeriod{1};

Clock::duration ToClock(std::chrono::duration<double> duration) {
  return std::chrono::duration_cast<Clock::duration>(duration);
}

class Capture {
 public:
  Capture(const ServiceContext& context, const CaptureOptions& options, FrameSource& source)
      : config_(context.config.capture()),
        options_(options),
        stop_(context.stop),
        source_(source),
        rig_id_(RigId(source.rig())),
        monitor_(context.stage, Digest(ConfigText(context.config))),
        publisher_(context.lcm_url, context.prefix),
        answers_(context, monitor_, options.lockstep.has_value()),
        reporter_(context, monitor_) {}

  int Run() {
    if (!WaitForStages()) return stop_.stop_requested() ? 0 : 1;
    PublishRig();
    const auto started = Clock::now();
    const std::optional<int64_t> count = FrameCount();
    for (int64_t seq = 0; !stop_.stop_requested() && (!count || seq < *count); ++seq) {
      WaitUntil(DueTime(started, seq));
      if (options_.lockstep) WaitForRoom(static_cast<size_t>(*options_.lockstep) - 1);
      if (!stop_.stop_requested()) SendNew(seq);
    }
    WaitForRoom(0);
    const StageStatus status = monitor_.Snapshot();
    spdlog::info("sent {} frames in {:.2f} s, {} again for want of an answer", status.frames_out,
                 std::chrono::duration<double>(Clock::now() - started).count(),
                 status.frames_resent);
    return 0;
  }

 private:
  // A frame on its way through the graph.
  struct InFlight {
    FrameId id;
    int64_t index;  // in the source
    Clock::time_point sent;
  };

  std::optional<int64_t> FrameCount() const {
    const std::optional<int64_t> available = options_.loop ? std::nullopt : source_.frame_count();
    if (!available) return options_.frames;
    if (options_.frames && *options_.frames > *available) {
      spdlog::warn("the source has {} of {} frames; --loop starts it again", *available,
                   *options_.frames);
    }
    return std::min(*available, options_.frames.value_or(*available));
  }

  Clock::time_point DueTime(Clock::time_point started, int64_t seq) const {
    if (config_.rate_hz() <= 0) return started;
    return started +
           ToClock(std::chrono::duration<double>(static_cast<double>(seq) / config_.rate_hz()));
  }

  bool WaitForStages() {
    const auto missing = answers_.WaitForStages(
        options_.wait_for, Clock::now() + ToClock(options_.wait_timeout), stop_);
    for (const std::string& stage : missing) {
      if (!stop_.stop_requested()) {
        spdlog::error(
            "no status from stage '{}' in {} s; is it running on this LCM URL and prefix?", stage,
            options_.wait_timeout.count());
      }
    }
    return missing.empty();
  }

  // Sleeps, but keeps sending the calibration.
  void WaitUntil(Clock::time_point due) {
    while (!stop_.stop_requested() && Clock::now() < due) {
      PublishRigWhenDue();
      std::this_thread::sleep_until(std::min(due, Clock::now() + std::chrono::milliseconds(50)));
    }
  }

  // Waits until at most `count` frames are without an answer; sends those again that wait too long.
  void WaitForRoom(size_t count) {
    while (!stop_.stop_requested() && in_flight_.size() > count) {
      answers_.WaitForRoom(count, Clock::now() + std::chrono::milliseconds(200), stop_);
      std::erase_if(in_flight_,
                    [&](const InFlight& frame) { return answers_.IsAnswered(frame.id.seq); });
      PublishRigWhenDue();
      SendOverdueAgain();
    }
  }

  void SendOverdueAgain() {
    for (InFlight& frame : in_flight_) {
      if (Clock::now() < frame.sent + ToClock(options_.lockstep_timeout)) continue;
      monitor_.FrameResent(frame.id);
      PublishRig();
      Send(frame.id, source_.Get(frame.index));
      frame.sent = Clock::now();
    }
  }

  void SendNew(int64_t seq) {
    const auto arrived = Clock::now();
    const std::optional<int64_t> count = source_.frame_count();
    const int64_t index = count ? seq % *count : seq;
    const CapturedFrame frame = source_.Get(index);
    // Captures are told apart by their time even when the clock is set back.
    newest_ = {std::max(NowUtime(), newest_.utime + 1), seq, rig_id_};
    monitor_.FrameIn(/*skipped=*/false);
    PublishRigWhenDue();
    if (options_.lockstep) {
      answers_.Expect(seq);
      in_flight_.push_back({newest_, index, Clock::now()});
    }
    Send(newest_, frame);
    monitor_.FrameOut(newest_, arrived, /*degenerate=*/"");
  }

  void Send(const FrameId& id, const CapturedFrame& frame) {
    Publish(id, Part::kLeft, config_.left_in_colour() ? frame.left : cv::Mat(ToGrey(frame.left)));
    Publish(id, Part::kRight,
            config_.right_in_colour() ? frame.right : cv::Mat(ToGrey(frame.right)));
    Publish(id, Part::kTof, frame.tof);
  }

  void PublishRigWhenDue() {
    if (Clock::now() >= next_rig_) PublishRig();
  }

  void PublishRig() {
    Publish({newest_.utime, std::max<int64_t>(newest_.seq, 0), rig_id_}, Part::kRig, source_.rig());
    next_rig_ = Clock::now() + kRigPeriod;
  }

  void Publish(const FrameId& id, Part part, const PartValue& value) {
    const auto bytes = EncodePart(id, part, value, DisparityEncoding::kRawInt16);
    if (!publisher_.Publish(ChannelOf(part), bytes)) {
      monitor_.Failure(std::string(ChannelOf(part)) + ": could not be published");
    }
  }

  const CaptureConfig& config_;
  const CaptureOptions& options_;
  std::stop_token stop_;
  FrameSource& source_;
  std::string rig_id_;
  StageMonitor monitor_;
  Publisher publisher_;
  Answers answers_;
  StatusReporter reporter_;
  FrameId newest_;
  Clock::time_point next_rig_{};
  std::vector<InFlight> in_flight_;
};

}  // namespace

int RunCapture(const ServiceContext& context, const CaptureOptions& options, FrameSource& source) {
  return Capture(context, options, source).Run();
}

}  // namespace sprout
