#include "services/capture/source_feed.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <utility>

#include "common/app/log_limiter.h"
#include "common/core/image.h"
#include "common/core/repeat_count.h"
#include "common/messages/codec.h"

namespace sprout::capture {
namespace {

// Times of frames follow a clock that was set back by more. For less, frames are stamped 1 µs apart
// until the clock has caught up; after a large step that would be wrong for hours.
constexpr int64_t kMaxHeldUs = 1'000'000;

// Warns of cameras that hang and give the same image again, to the last bit, which noise prevents
// in one that works. The warning holds until the image changes.
class FrozenWatch {
 public:
  explicit FrozenWatch(StageMonitor& monitor) : monitor_(monitor) {}

  // Takes the images of the next frame; empty ones are not looked at.
  void Add(const scenes::CapturedFrame& frame) {
    Compare(cameras_[0], frame.left);
    Compare(cameras_[1], frame.right);
    Compare(cameras_[2], frame.tof.depth_m);
  }

 private:
  static constexpr int kImages = 10;  // that must be equal in a row for a warning

  struct Camera {
    const char* name;
    RepeatCount count = {};
    std::string warning = {};
  };

  void Compare(Camera& camera, const cv::Mat& image) {
    if (image.empty()) return;
    const int same = camera.count.Add(image);
    if (same == kImages) {
      camera.warning = fmt::format(
          "the {} camera gives the same image again and again, bit for bit: it hangs, or sees "
          "nothing",
          camera.name);
      monitor_.Warn(camera.warning);
      monitor_.HoldWarning(camera.warning);
    } else if (same == 1 && !camera.warning.empty()) {
      monitor_.Resolve(camera.warning);
      camera.warning.clear();
    }
  }

  StageMonitor& monitor_;
  std::array<Camera, 3> cameras_ = {Camera{"left"}, Camera{"right"}, Camera{"range"}};
};

class SourceFeed : public CaptureFeed {
 public:
  // If there is no rig, frames are not rectified. `current` is null when that is done elsewhere.
  SourceFeed(std::unique_ptr<scenes::TripletSource> source, std::optional<Rig> rig,
             std::shared_ptr<CurrentRig> current, const CaptureConfig& config,
             StageMonitor& monitor, std::function<int64_t()> now)
      : source_(std::move(source)),
        rig_(std::move(rig)),
        current_(std::move(current)),
        config_(config),
        monitor_(monitor),
        frozen_(monitor),
        now_(std::move(now)) {
    if (rig_) newest_.rig_id = RigId(*rig_);
  }

  std::optional<CaptureMessages> Next(const std::stop_token& stop) override {
    std::optional<scenes::CapturedFrame> frame = source_->Next(stop);
    if (!frame) {
      const scenes::LostFrames lost = source_->lost_at_end();
      lacks_most_ = lost.lacks_most;
      CountLost(lost);
      return std::nullopt;
    }
    CountLost({.count = frame->lost, .trouble = frame->trouble});
    if (source_->is_live()) {
      monitor_.SetSpread(frame->spread_ms);
      frozen_.Add(*frame);
    }
    const int64_t utime = frame->utime ? *frame->utime : now_();
    const int64_t set_back_us = std::exchange(sources_utime_, utime) - utime;
    // A recording that begins again keeps its times, which give its pace.
    const bool is_followed =
        source_->is_recorded() ? set_back_us > 0 : newest_.utime - utime > kMaxHeldUs;
    if (!source_->is_recorded()) {
      WarnClockSetBack(frame->utime ? "the cameras'" : "this host's", set_back_us, is_followed);
    }
    newest_.utime = is_followed ? utime : std::max(utime, newest_.utime + 1);
    ++newest_.seq;
    if (!config_.left_in_colour()) frame->left = ToGrey(frame->left);
    frame->right = ToGrey(frame->right);
    if (!frame->new_rig) return Encoded(newest_, *frame);
    rig_ = frame->new_rig->rig;
    newest_.rig_id = frame->new_rig->rig_id;
    return BehindCalibration(Calibration(), Encoded(newest_, *frame));
  }

  std::vector<uint8_t> Calibration() const override {
    if (!rig_) return {};
    const FrameId id{newest_.utime, std::max<int64_t>(newest_.seq, 0), newest_.rig_id};
    return EncodePart(id, Part::kRig, *rig_);
  }

  Timing timing() const override {
    if (source_->is_live()) return Timing::kLive;
    return source_->is_recorded() ? Timing::kRecorded : Timing::kAsked;
  }

  bool lacks_something() const override { return lacks_most_; }

  std::shared_ptr<CurrentRig> current_rig() const override { return current_; }

 private:
  void CountLost(const scenes::LostFrames& lost) {
    if (lost.count > 0) monitor_.CapturesFailed(lost.count, lost.trouble);
    if (lost.count == 0 && !lost.trouble.empty()) monitor_.Failure(lost.trouble);
  }

  // Warns if the clock that frames are stamped with was set back.
  void WarnClockSetBack(const char* whose, int64_t set_back_us, bool is_followed) {
    if (set_back_us <= 0 || !clock_log_.Pass(StageMonitor::Clock::now())) return;
    monitor_.Warn(fmt::format(
        "{} clock was set back by {:.3f} s: {}", whose, static_cast<double>(set_back_us) * 1e-6,
        is_followed ? "the times of frames go back, too"
                    : "until it is there again, frames are stamped 1 µs apart"));
  }

  std::unique_ptr<scenes::TripletSource> source_;
  std::optional<Rig> rig_;
  std::shared_ptr<CurrentRig> current_;
  CaptureConfig config_;
  StageMonitor& monitor_;
  FrozenWatch frozen_;
  std::function<int64_t()> now_;
  FrameId newest_;
  int64_t sources_utime_ = 0;  // of the newest frame, by the source
  LogLimiter clock_log_;
  bool lacks_most_ = false;
};

}  // namespace

CaptureMessages Encoded(const FrameId& id, const scenes::CapturedFrame& frame) {
  CaptureMessages messages{.id = id, .messages = {}};
  const auto add = [&](Part part, const PartValue& value) {
    messages.messages.emplace_back(part, EncodePart(id, part, value));
  };
  add(Part::kLeft, frame.left);
  add(Part::kRight, frame.right);
  if (frame.tof_zones) add(Part::kTofZones, *frame.tof_zones);
  add(Part::kTof, frame.tof);
  return messages;
}

CaptureMessages BehindCalibration(std::vector<uint8_t> calibration, CaptureMessages frame) {
  frame.messages.emplace(frame.messages.begin(), Part::kRig, std::move(calibration));
  return frame;
}

std::unique_ptr<CaptureFeed> FeedFrom(std::unique_ptr<scenes::FrameSource> source,
                                      const CaptureConfig& config, StageMonitor& monitor,
                                      std::shared_ptr<CurrentRig> rig,
                                      std::function<int64_t()> now) {
  const Rig first = source->rig();
  return std::make_unique<SourceFeed>(std::move(source), first, std::move(rig), config, monitor,
                                      std::move(now));
}

std::unique_ptr<CaptureFeed> RawFeedFrom(std::unique_ptr<RawSource> cameras,
                                         const CaptureConfig& config, StageMonitor& monitor) {
  return std::make_unique<SourceFeed>(std::move(cameras), std::nullopt, nullptr, config, monitor,
                                      NowUtime);
}

}  // namespace sprout::capture
