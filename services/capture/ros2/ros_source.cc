#include "services/capture/ros2/ros_source.h"

#include <chrono>
#include <optional>
#include <utility>

#include "common/config/config_error.h"
#include "common/rig/rig_file.h"
#include "services/capture/ros2/ros_calibration.h"
#include "services/capture/ros2/ros_triplets.h"
#include "services/datasets/tof_grid.h"
#include "services/datasets/velodyne_scan.h"

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
    if (settings_.file.empty()) return ListenToRos(settings_, options_.tell, options_.waiting);
    return ReadRosFile(settings_, options_.tell);
  }

  /// Images as the cameras see them need no calibration, which may not be there yet.
  void LeaveOutCalibration() {
    settings_.left_info.clear();
    settings_.right_info.clear();
    settings_.depth_info.clear();
  }

  void Tell(const std::string& what) const { options_.tell(what); }

  ConfigError Bad(const std::string& reason) const {
    return ConfigError("capture.source = " + source_ + ": " + reason);
  }

  const RosSettings& settings() const { return settings_; }
  bool loop() const { return options_.loop && !settings_.file.empty(); }

 private:
  std::string source_;
  RosSourceOptions options_;
  RosSettings settings_;
};

// Frames of messages, whatever becomes of them.
class RosFrames {
 public:
  RosFrames(RosOpener opener, std::unique_ptr<RosInput> input, std::optional<cv::Size> size,
            ImageOfPoints image)
      : opener_(std::move(opener)),
        input_(std::move(input)),
        size_(size),
        image_(std::move(image)),
        triplets_(opener_.settings(), size_, image_) {}

  bool is_live() const { return input_->is_live(); }

  std::optional<datasets::CapturedFrame> Next(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      if (std::optional<datasets::CapturedFrame> frame = triplets_.Next()) {
        gave_any_ = true;
        return frame;
      }
      RosBytes message;
      if (input_->Next(message, stop)) {
        triplets_.Take(message);
      } else if (!is_at_end_) {
        triplets_.Finish();
        is_at_end_ = true;
      } else if (opener_.loop() && std::exchange(gave_any_, false)) {
        input_ = opener_.Open();
        triplets_ = RosTriplets(opener_.settings(), size_, image_);
        is_at_end_ = false;
      } else {
        break;
      }
    }
    return std::nullopt;
  }

  datasets::LostFrames lost_at_end() { return triplets_.TakeLost(); }

 private:
  RosOpener opener_;
  std::unique_ptr<RosInput> input_;
  std::optional<cv::Size> size_;
  ImageOfPoints image_;
  RosTriplets triplets_;
  bool is_at_end_ = false;
  bool gave_any_ = false;
};

class RawRosSource : public RawSource {
 public:
  explicit RawRosSource(RosFrames frames) : frames_(std::move(frames)) {}
  bool is_live() const override { return frames_.is_live(); }
  bool is_recorded() const override { return !is_live(); }
  std::optional<datasets::CapturedFrame> Next(const std::stop_token& stop) override {
    return frames_.Next(stop);
  }
  datasets::LostFrames lost_at_end() const override { return frames_.lost_at_end(); }

 private:
  mutable RosFrames frames_;
};

class RosSource : public datasets::FrameSource {
 public:
  // @param rectifier  of raw images.
  RosSource(RosFrames frames, const Rig& rig, std::optional<Rectifier> rectifier)
      : frames_(std::move(frames)), rig_(rig), rectifier_(std::move(rectifier)) {}

  const Rig& rig() const override { return rig_; }
  bool is_live() const override { return frames_.is_live(); }
  bool is_recorded() const override { return !is_live(); }

  std::optional<datasets::CapturedFrame> Next(const std::stop_token& stop) override {
    std::optional<datasets::CapturedFrame> frame = frames_.Next(stop);
    if (!frame || !rectifier_) return frame;
    frame->left = rectifier_->RectifyLeft(frame->left);
    frame->right = rectifier_->RectifyRight(frame->right);
    const bool is_of_tof = frame->tof.depth_m.size() == rectifier_->raw().tof.size();
    if (is_of_tof) rectifier_->CorrectRanges(frame->tof);
    return frame;
  }

  datasets::LostFrames lost_at_end() const override { return frames_.lost_at_end(); }

 private:
  mutable RosFrames frames_;
  Rig rig_;
  std::optional<Rectifier> rectifier_;
};

ImageOfPoints Projector(const RosRig& rig) {
  return [rig](const std::vector<Eigen::Vector3d>& points) {
    return datasets::TofImageFromScan(points, rig.left_from_points, rig.rig.pair);
  };
}

std::string TopicOf(const RosSettings& settings, RosRole role) {
  const std::vector<std::string> topics = settings.TopicsOf(role);
  return topics.empty() ? "" : topics.front();
}

// Of a file all messages may be looked at, of a live graph those of kCalibrationWait.
RosRig FindCalibration(const RosOpener& opener, RosInput& input) {
  RosCalibration calibration(opener.settings());
  const Clock::time_point deadline = Clock::now() + kCalibrationWait;
  std::string refused;
  const std::stop_source never;
  for (RosBytes message; calibration.Missing() && Clock::now() < deadline;) {
    if (!input.Next(message, never.get_token())) break;
    if (const Result<void> taken = calibration.Take(message); !taken) {
      refused = TopicOf(opener.settings(), message.role) + ": " + taken.error().text;
    }
  }
  if (const std::optional<RosRole> missing = calibration.Missing()) {
    if (!refused.empty()) throw opener.Bad(refused);
    if (*missing == RosRole::kTf) throw opener.Bad(calibration.MissingTransform());
    throw opener.Bad("no message on " + TopicOf(opener.settings(), *missing) + "; " +
                     input.Instead(*missing));
  }
  const Result<RosRig> rig = calibration.Rig();
  if (!rig) throw opener.Bad(rig.error().text);
  if (const std::string note = input.Note(); !note.empty()) opener.Tell(note);
  return *rig;
}

std::unique_ptr<datasets::FrameSource> OpenWithRigFile(const RosOpener& opener) {
  const RosSettings& settings = opener.settings();
  Rectifier rectifier(RequireCalibration(LoadRigFile(settings.rig), settings.rig));
  RosRig rig{.rig = rectifier.rig()};
  ImageOfPoints image;
  if (!settings.points.empty()) {
    const TofCamera sensor = rig.rig.tof;
    if (sensor.width == 0) {
      throw opener.Bad("no tof in " + settings.rig + ", whose pose is that of the points' sensor");
    }
    rig.left_from_points = Eigen::Translation3d(sensor.left_from_tof_translation_m) *
                           Eigen::Quaterniond(sensor.left_from_tof_rotation);
    rig.rig.tof = datasets::TofGridCamera(rig.rig.pair, 1);
    image = Projector(rig);
  } else if (settings.depth.empty()) {
    rig.rig.tof = {};
  }
  RosFrames frames(opener, opener.Open(), rectifier.raw().left.size(), std::move(image));
  return std::make_unique<RosSource>(std::move(frames), rig.rig, std::move(rectifier));
}

}  // namespace

std::unique_ptr<datasets::FrameSource> OpenRosSource(const std::string& source,
                                                     RosSourceOptions options) {
  const RosOpener opener(source, std::move(options));
  if (!opener.settings().rig.empty()) return OpenWithRigFile(opener);
  std::unique_ptr<RosInput> input = opener.Open();
  const RosRig rig = FindCalibration(opener, *input);
  // A file is read from its begin again; live, a reader has heard of the topics by now.
  if (!input->is_live()) input = opener.Open();
  const bool has_points = !opener.settings().points.empty();
  RosFrames frames(opener, std::move(input), rig.rig.pair.size(),
                   has_points ? Projector(rig) : ImageOfPoints());
  return std::make_unique<RosSource>(std::move(frames), rig.rig, std::nullopt);
}

std::unique_ptr<RawSource> OpenRawRosSource(const std::string& source, RosSourceOptions options) {
  RosOpener opener(source, std::move(options));
  opener.LeaveOutCalibration();
  RosFrames frames(opener, opener.Open(), std::nullopt, {});
  return std::make_unique<RawRosSource>(std::move(frames));
}

}  // namespace sprout::capture
