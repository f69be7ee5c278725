#include "services/capture/ros2/ros_source.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "common/app/log_limiter.h"
#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/core/joined.h"
#include "common/rig/rig_file.h"
#include "common/scenes/tof_grid.h"
#include "common/scenes/velodyne_scan.h"
#include "services/capture/ros2/ros_calibration.h"
#include "services/capture/ros2/ros_triplets.h"

namespace sprout::capture {
namespace {

using Clock = std::chrono::steady_clock;

// How long the calibration of a live rig is waited for: less than systemd gives a service to start.
constexpr std::chrono::seconds kCalibrationWait{20};

// A source as it was asked for, which can be opened again.
class RosOpener {
 public:
  RosOpener(std::string source, RosSourceOptions options)
      : source_(std::move(source)),
        options_(std::move(options)),
        settings_(ParseRosSource(source_)) {}

  std::unique_ptr<RosInput> Open() const {
    if (settings_.file.empty()) return ListenToRos(settings_, options_.reports, options_.waiting);
    return ReadRosFile(settings_, options_.reports);
  }

  /// For raw images, whose calibration may not exist yet.
  void LeaveOutCalibration() {
    settings_.left_info.clear();
    settings_.right_info.clear();
    settings_.depth_info.clear();
  }

  void Tell(const std::string& what) const { options_.reports.tell(what); }

  ConfigError Bad(const std::string& reason) const {
    return ConfigError("capture.source = " + source_ + ": " + reason);
  }

  const RosSettings& settings() const { return settings_; }
  const RosReports& reports() const { return options_.reports; }
  const std::stop_token& stop() const { return options_.stop; }
  bool loop() const { return options_.loop && !settings_.file.empty(); }

 private:
  std::string source_;
  RosSourceOptions options_;
  RosSettings settings_;
};

ImageOfPoints Projector(const RosRig& rig) {
  return [rig](const std::vector<Eigen::Vector3d>& points) {
    return scenes::TofImageFromScan(points, rig.left_from_points, rig.rig.pair);
  };
}

std::string TopicOf(const RosSettings& settings, RosRole role) {
  const std::vector<std::string> topics = settings.TopicsOf(role);
  return topics.empty() ? "" : topics.front();
}

// Nobody sends more than 8 bytes a pixel (RGBA of 16 bits), or a header of 64 kB.
RosLimits LimitsFor(cv::Size images, cv::Size tof) {
  constexpr size_t kBytesPerPixel = 8;
  constexpr size_t kHeader = size_t{64} << 10;
  const auto pixels = static_cast<size_t>(std::max(images.area(), tof.area()));
  return {.image_bytes = kBytesPerPixel * pixels + kHeader};
}

// Size of the range images; nothing where there are none.
std::optional<cv::Size> RangeSizeOf(const RosSettings& settings, const TofCamera& tof) {
  if (settings.depth.empty()) return std::nullopt;
  return cv::Size(tof.width, tof.height);
}

// The frames of a source's messages, rectified or raw as they come.
class RosFrames : public RawSource {
 public:
  // @param watch  of the calibration by CameraInfo; nothing when that is not read.
  RosFrames(RosOpener opener, std::unique_ptr<RosInput> input, std::optional<cv::Size> size,
            std::optional<cv::Size> range_size, ImageOfPoints image,
            std::optional<RosRigWatch> watch = {})
      : opener_(std::move(opener)),
        input_(std::move(input)),
        watch_(std::move(watch)),
        size_(size),
        rig_size_(size),
        range_size_(range_size),
        image_(std::move(image)),
        triplets_(opener_.settings(), size_, range_size_, image_) {}

  bool is_live() const override { return input_->is_live(); }
  bool is_recorded() const override { return !is_live(); }

  std::optional<scenes::CapturedFrame> Next(const std::stop_token& stop) override {
    while (!stop.stop_requested()) {
      if (std::optional<scenes::CapturedFrame> frame = TakeFrame()) return frame;
      RosBytes message;
      if (input_->Next(message, stop)) {
        Take(message);
      } else if (!is_at_end_) {
        triplets_.Finish();
        is_at_end_ = true;
      } else if (opener_.loop() && std::exchange(gave_any_, false)) {
        input_->StartImages({});
        triplets_ = RosTriplets(opener_.settings(), size_, range_size_, image_);
        is_at_end_ = false;
      } else {
        break;
      }
    }
    return std::nullopt;
  }

  scenes::LostFrames lost_at_end() const override {
    scenes::LostFrames lost = triplets_.TakeLost();
    // Rectified images may be called image_raw, or have the D of raw ones, but hardly both.
    const RosSettings& settings = opener_.settings();
    if (!is_live() && watch_ && NameHas(settings.left, "raw") && NameHas(settings.right, "raw")) {
      const std::string raw = watch_->RawImages();
      lost.lacks_most |= !raw.empty();
      lost.trouble = JoinedTexts(raw, lost.trouble);
    }
    if (misfits_ < 2) return lost;
    lost.lacks_most = true;
    lost.trouble = fmt::format("the last {} pairs fit no calibration: {}", misfits_, misfit_);
    return lost;
  }

 private:
  void Take(const RosBytes& message) {
    const std::string topic = TopicOf(opener_.settings(), message.role);
    if (watch_) {
      const Result<bool> is_new = watch_->Take(message);
      if (!is_new) opener_.reports().Refuse(topic, is_new.error().text);
      if (is_new && *is_new) UseRig(watch_->rig());
      std::string other_frame = watch_->OtherFrame(message);
      if (!other_frame.empty() && other_frame != other_frame_) opener_.Tell(other_frame);
      if (!other_frame.empty()) other_frame_ = std::move(other_frame);
    }
    if (const Result<void> taken = triplets_.Take(message); !taken) {
      opener_.reports().Refuse(topic, taken.error().text);
    }
  }

  // Images of the new size may come before the frame with the new rig.
  void UseRig(const RosRig& rig) {
    const int before = size_->area();
    size_ = rig.rig.pair.size();
    range_size_ = RangeSizeOf(opener_.settings(), rig.rig.tof);
    if (image_) image_ = Projector(rig);
    triplets_.Use(*size_, range_size_, image_);
    // A sensor that turns on its mount changes with each message of /tf.
    if (const auto held_back = change_log_.Pass(Clock::now())) {
      opener_.reports().tell("the calibration changed: " + RigId(rig.rig) + ", images of " +
                             SizeText(*size_) + MoreText(*held_back));
    }
    const RosLimits limits = LimitsFor(*size_, {rig.rig.tof.width, rig.rig.tof.height});
    if (is_live() && size_->area() > before) input_->StartImages(limits);
  }

  // A frame that has a calibration. Losses are reported at once when no frame comes to report them.
  std::optional<scenes::CapturedFrame> TakeFrame() {
    while (std::optional<scenes::CapturedFrame> frame = triplets_.Next()) {
      gave_any_ = true;
      if (!watch_) return frame;
      std::string trouble = watch_->trouble();
      if (const std::optional<RosRig> rig = watch_->TakeNewRig(frame->utime.value_or(0))) {
        new_rig_ = scenes::NamedRig{rig->rig, RigId(rig->rig)};
        rig_size_ = rig->rig.pair.size();
      }
      if (trouble.empty() && frame->left.size() != *rig_size_) {
        trouble = "images of " + SizeText(frame->left.size()) + ": the calibration changed to " +
                  SizeText(*rig_size_);
      }
      misfits_ = trouble.empty() ? 0 : misfits_ + 1;
      misfit_ = trouble;
      if (trouble.empty()) {
        frame->new_rig = std::exchange(new_rig_, std::nullopt);
        return frame;
      }
      if (opener_.reports().lost) opener_.reports().lost({frame->lost + 1, std::move(trouble)});
    }
    const scenes::LostFrames lost = triplets_.TakeLost();
    if (lost.count > 0 && opener_.reports().lost) opener_.reports().lost(lost);
    return std::nullopt;
  }

  RosOpener opener_;
  std::unique_ptr<RosInput> input_;
  std::optional<RosRigWatch> watch_;
  std::optional<cv::Size> size_;
  std::optional<cv::Size> rig_size_;  // of the frames' rig; size_ may be a newer one
  std::optional<cv::Size> range_size_;
  LogLimiter change_log_;
  std::optional<scenes::NamedRig> new_rig_ = {};  // for the next frame
  ImageOfPoints image_;
  mutable RosTriplets triplets_;  // lost_at_end() takes the losses out of it
  std::string other_frame_;       // newest warning of OtherFrame()
  bool is_at_end_ = false;
  bool gave_any_ = false;
  int misfits_ = 0;     // frames in a row
  std::string misfit_;  // why the last one was
};

class RosSource : public scenes::FrameSource {
 public:
  // @param rectifier  of raw images.
  RosSource(RosFrames frames, const Rig& rig, std::optional<Rectifier> rectifier)
      : frames_(std::move(frames)), rig_(rig), rectifier_(std::move(rectifier)) {}

  const Rig& rig() const override { return rig_; }
  bool is_live() const override { return frames_.is_live(); }
  bool is_recorded() const override { return !is_live(); }

  std::optional<scenes::CapturedFrame> Next(const std::stop_token& stop) override {
    std::optional<scenes::CapturedFrame> frame = frames_.Next(stop);
    if (!frame || !rectifier_) return frame;
    frame->left = rectifier_->RectifyLeft(frame->left);
    frame->right = rectifier_->RectifyRight(frame->right);
    const bool is_of_tof = frame->tof.depth_m.size() == rectifier_->raw().tof.size();
    if (is_of_tof) rectifier_->CorrectRanges(frame->tof);
    return frame;
  }

  scenes::LostFrames lost_at_end() const override { return frames_.lost_at_end(); }

 private:
  RosFrames frames_;
  Rig rig_;
  std::optional<Rectifier> rectifier_;
};

// A rig, and the calibration that it was made of, which takes later messages.
struct FoundRig {
  RosCalibration calibration;
  RosRig rig;
};

// Looks for the calibration in all messages of a file, or in those of a live graph that come within
// kCalibrationWait. Nothing when a stop was asked for.
std::optional<FoundRig> FindCalibration(const RosOpener& opener, RosInput& input) {
  RosCalibration calibration(opener.settings());
  const Clock::time_point deadline =
      input.is_live() ? Clock::now() + kCalibrationWait : Clock::time_point::max();
  std::string refused;
  for (RosBytes message; calibration.Missing();) {
    if (!input.Next(message, opener.stop(), deadline)) break;
    if (const Result<bool> taken = calibration.Take(message); !taken) {
      const std::string topic = TopicOf(opener.settings(), message.role);
      refused = topic + ": " + taken.error().text;
      if (input.is_live()) opener.reports().Refuse(topic, taken.error().text);
    }
  }
  if (opener.stop().stop_requested()) return std::nullopt;
  if (const std::optional<RosRole> missing = calibration.Missing()) {
    if (!refused.empty()) throw opener.Bad(refused);
    if (*missing == RosRole::kTf) throw opener.Bad(calibration.MissingTransform());
    throw opener.Bad("no message on " + TopicOf(opener.settings(), *missing) + "; " +
                     input.Alternatives(*missing));
  }
  Result<RosRig> rig = calibration.Rig();
  if (!rig) throw opener.Bad(rig.error().text);
  for (const std::string& note : {input.Note(), calibration.RawImages()}) {
    if (!note.empty()) opener.Tell(note);
  }
  return FoundRig{std::move(calibration), std::move(*rig)};
}

std::unique_ptr<scenes::FrameSource> OpenWithRigFile(const RosOpener& opener) {
  const RosSettings& settings = opener.settings();
  Rectifier rectifier(RequireCalibration(LoadRigFile(settings.rig), settings.rig));
  RosRig rig{.rig = rectifier.rig()};
  ImageOfPoints image;
  const bool has_range = !settings.points.empty() || !settings.depth.empty();
  if (has_range && rig.rig.tof.width == 0) {
    throw opener.Bad("no tof in " + settings.rig + ", whose pose is that of the range sensor");
  }
  if (!settings.points.empty()) {
    const TofCamera sensor = rig.rig.tof;
    rig.left_from_points = Eigen::Translation3d(sensor.left_from_tof_translation_m) *
                           Eigen::Quaterniond(sensor.left_from_tof_rotation);
    rig.rig.tof = scenes::TofGridCamera(rig.rig.pair, 1);
    image = Projector(rig);
  } else if (settings.depth.empty()) {
    rig.rig.tof = {};
  }
  const cv::Size size = rectifier.raw().left.size();
  std::unique_ptr<RosInput> input = opener.Open();
  input->StartImages(LimitsFor(size, rectifier.raw().tof.size()));
  RosFrames frames(opener, std::move(input), size, RangeSizeOf(settings, rig.rig.tof),
                   std::move(image));
  return std::make_unique<RosSource>(std::move(frames), rig.rig, std::move(rectifier));
}

}  // namespace

std::unique_ptr<scenes::FrameSource> OpenRosSource(const std::string& source,
                                                   RosSourceOptions options) {
  const RosOpener opener(source, std::move(options));
  if (!opener.settings().rig.empty()) return OpenWithRigFile(opener);
  std::unique_ptr<RosInput> input = opener.Open();
  std::optional<FoundRig> found = FindCalibration(opener, *input);
  if (!found) return nullptr;
  const RosRig rig = found->rig;
  const cv::Size size = rig.rig.pair.size();
  input->StartImages(LimitsFor(size, {rig.rig.tof.width, rig.rig.tof.height}));
  const bool has_points = !opener.settings().points.empty();
  RosFrames frames(opener, std::move(input), size, RangeSizeOf(opener.settings(), rig.rig.tof),
                   has_points ? Projector(rig) : ImageOfPoints(),
                   RosRigWatch(std::move(found->calibration), rig));
  return std::make_unique<RosSource>(std::move(frames), rig.rig, std::nullopt);
}

std::unique_ptr<RawSource> OpenRawRosSource(const std::string& source, RosSourceOptions options) {
  RosOpener opener(source, std::move(options));
  opener.LeaveOutCalibration();
  std::unique_ptr<RosInput> input = opener.Open();
  input->StartImages({});
  return std::make_unique<RosFrames>(opener, std::move(input), std::nullopt, std::nullopt,
                                     ImageOfPoints());
}

}  // namespace sprout::capture
