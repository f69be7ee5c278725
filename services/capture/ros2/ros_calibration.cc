#include "services/capture/ros2/ros_calibration.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "common/core/printable.h"
#include "common/geometry/lens.h"
#include "common/rig/raw_rig.h"
#include "common/scenes/tof_grid.h"

namespace sprout::capture {
namespace {

// The turn from the camera's frame to the rectified left camera's, as in Sprout: by R.
Eigen::Quaterniond TurnOf(const RosCamera& left) {
  return left.rectification.isIdentity(0) ? Eigen::Quaterniond::Identity()
                                          : Eigen::Quaterniond(left.rectification);
}

// How much older a frame may be that comes behind the CameraInfo of a later one, µs.
constexpr int64_t kMaxOvertakenUs = 1'000'000;

// Most frames of /tf whose poses are kept: trackers give what they see ever new names.
constexpr size_t kMaxPoses = 10'000;

// Most frames that are named whose transforms cannot be used, or come from several parents.
constexpr size_t kMaxNamed = 20;

// ROS 1 allowed a slash in front of a frame, and what was converted from it may have one in some of
// its messages.
std::string_view FrameName(std::string_view frame) {
  return frame.substr(frame.starts_with('/') ? 1 : 0);
}

// A message behind CDR's header and the stamp.
std::span<const uint8_t> BehindStamp(const RosBytes& message) {
  constexpr size_t kBehindStamp = 12;
  return message.cdr.subspan(std::min(kBehindStamp, message.cdr.size()));
}

// Whether rigs are equal but for the rounding of a pose that is made of others: /tf comes often.
bool AreEqual(const RosRig& a, RosRig b) {
  constexpr double kRounding = 1e-7;  // m and rad
  const auto& turn_a = a.rig.tof.left_from_tof_rotation;
  auto& turn_b = b.rig.tof.left_from_tof_rotation;
  auto& place_b = b.rig.tof.left_from_tof_translation_m;
  const bool is_tof_there = (turn_a.coeffs() - turn_b.coeffs()).norm() < kRounding &&
                            (a.rig.tof.left_from_tof_translation_m - place_b).norm() < kRounding;
  const bool are_points_there =
      (a.left_from_points.matrix() - b.left_from_points.matrix()).norm() < kRounding;
  turn_b = turn_a;
  place_b = a.rig.tof.left_from_tof_translation_m;
  return is_tof_there && are_points_there && RigId(a.rig) == RigId(b.rig);
}

// Largest distance that rectifying by D and R moves a pixel in the middle of the image, px; 0 when
// the lens is not known.
double MovedPx(const RosCamera& camera) {
  if (!camera.lens) return 0;
  Lens straight = *camera.lens;
  straight.distortion = {};
  double most = 0;
  for (const double across : {0.25, 0.5, 0.75}) {
    for (const double down : {0.25, 0.5, 0.75}) {
      const Eigen::Vector2d pixel(across * camera.width, down * camera.height);
      const Eigen::Vector2d seen = DirectionOfPixel(straight, pixel);
      const Eigen::Vector3d ray = camera.rectification.transpose() * seen.homogeneous();
      if (ray.z() <= 0) continue;
      const Eigen::Vector2d raw = PixelOfDirection(*camera.lens, ray.hnormalized());
      most = std::max(most, (raw - pixel).norm());
    }
  }
  return most;
}

}  // namespace

Result<bool> RosCalibration::TakeInfo(const RosBytes& message, std::optional<Named>& to) {
  const auto cdr = BehindStamp(message);  // drivers send the same one with each image
  if (to && std::ranges::equal(cdr, to->cdr)) return false;
  const Result<RosMessage<RosCameraInfo>> info = ReadCdr<RosCameraInfo>(message.cdr);
  if (!info) return tl::unexpected(info.error());
  const bool is_rectified = message.role != RosRole::kDepthInfo || settings_.DepthIsRectified();
  Result<RosCamera> camera = FromRosInfo(**info, is_rectified);
  if (!camera) return tl::unexpected(camera.error());
  const Result<int64_t> utime = FromRosStamp((*info)->header);
  if (!utime) return tl::unexpected(utime.error());
  changed_utime_ = *utime;
  to = Named{.camera = std::move(*camera),
             .frame = std::string(RosText((*info)->header.frame_id)),
             .cdr = {cdr.begin(), cdr.end()}};
  return true;
}

Result<bool> RosCalibration::TakeTransforms(const RosBytes& message) {
  const Result<RosMessage<RosTransforms>> transforms = ReadCdr<RosTransforms>(message.cdr);
  if (!transforms) return tl::unexpected(transforms.error());
  bool is_any_usable = false;
  Result<bool> outcome = false;
  for (const RosTransform& one : RosSpan((*transforms)->transforms)) {
    Result<RosPose> pose = FromRosTransform(one);
    if (!pose) {  // mostly of a joint that is not needed
      if (outcome) outcome = tl::unexpected(pose.error());
      if (unusable_.size() < kMaxNamed) unusable_.emplace(FrameName(RosText(one.child_frame_id)));
      continue;
    }
    is_any_usable = true;
    pose->parent = FrameName(pose->parent);
    pose->child = FrameName(pose->child);
    const auto known = poses_.find(pose->child);
    if (poses_.size() == kMaxPoses && known == poses_.end()) continue;
    const bool has_moved = known != poses_.end() && known->second.parent != pose->parent;
    if (has_moved && moved_.size() < kMaxNamed) moved_.insert(pose->child);
    unusable_.erase(pose->child);
    poses_.insert_or_assign(pose->child, *std::move(pose));
  }
  return is_any_usable ? true : outcome;
}

Result<bool> RosCalibration::TakePointsFrame(const RosBytes& message) {
  const auto cdr = BehindStamp(message);  // begins with the frame's length, text and a zero
  const size_t known = points_frame_cdr_.size();
  if (points_frame_ && cdr.size() >= known &&
      std::ranges::equal(cdr.first(known), points_frame_cdr_)) {
    return false;
  }
  const Result<RosMessage<RosPointCloud>> cloud = ReadCdr<RosPointCloud>(message.cdr);
  if (!cloud && points_frame_) return false;  // RosTriplets reports what is wrong
  if (!cloud) return tl::unexpected(cloud.error());
  points_frame_ = RosText((*cloud)->header.frame_id);
  const auto frame = cdr.first(sizeof(uint32_t) + points_frame_->size() + 1);
  points_frame_cdr_.assign(frame.begin(), frame.end());
  return true;
}

Result<bool> RosCalibration::Take(const RosBytes& message) {
  switch (message.role) {
    case RosRole::kLeftInfo:
      return TakeInfo(message, left_);
    case RosRole::kRightInfo:
      return TakeInfo(message, right_);
    case RosRole::kDepthInfo:
      return TakeInfo(message, depth_);
    case RosRole::kPoints:
      return TakePointsFrame(message);
    case RosRole::kTf:
      return TakeTransforms(message);
    case RosRole::kLeft:
    case RosRole::kRight:
    case RosRole::kDepth:
      break;
  }
  return false;
}

std::string RosCalibration::OtherFrame(const RosBytes& message) const {
  if (message.role != RosRole::kDepth || !depth_ || depth_->frame.empty()) return "";
  const auto cdr = BehindStamp(message);
  const size_t size = sizeof(uint32_t) + depth_->frame.size() + 1;  // length, text and a zero
  if (cdr.size() >= size && std::ranges::equal(cdr.first(size), std::span(depth_->cdr).first(size)))
    return "";
  const auto frame_of = [&]<typename Ros>() {
    const Result<RosMessage<Ros>> image = ReadCdr<Ros>(message.cdr);
    return image ? std::string(RosText((*image)->header.frame_id)) : "";
  };
  const std::string frame = message.is_compressed ? frame_of.operator()<RosCompressedImage>()
                                                  : frame_of.operator()<RosImage>();
  if (frame.empty() || FrameName(frame) == FrameName(depth_->frame)) return "";
  return "range images of " + settings_.depth + " are of frame '" + Printable(frame) +
         "', and their CameraInfo " + settings_.depth_info + " of '" + Printable(depth_->frame) +
         "', whose place is taken";
}

std::string RosCalibration::RawImages() const {
  constexpr double kMinMovedPx = 1;  // less is rounding
  const double moved_px = std::max(MovedPx(left_->camera), MovedPx(right_->camera));
  if (moved_px < kMinMovedPx || (SaysRectified(settings_.left) && SaysRectified(settings_.right))) {
    return "";
  }
  return fmt::format(
      "images of {} and {} are taken for rectified, but D and R of their CameraInfo move pixels by "
      "up to {:.1f} px; if they are raw, give the topics of rectified ones, or rig=FILE with what "
      "sprout-calibrate import makes of both CameraInfo",
      settings_.left, settings_.right, moved_px);
}

// Pose of a frame in the root frame, the one that has no parent.
std::optional<RosPose> RosCalibration::PoseInRoot(std::string_view frame) const {
  const std::string name(FrameName(frame));
  RosPose pose{.parent = name, .child = name};
  for (size_t steps = 0; steps <= poses_.size(); ++steps) {
    const auto up = poses_.find(pose.parent);
    if (up == poses_.end()) return pose;
    pose.parent = up->second.parent;
    pose.parent_from_child = up->second.parent_from_child * pose.parent_from_child;
  }
  return std::nullopt;  // the transforms form a circle
}

// Pose of a frame in the left camera's; nothing when /tf_static does not say.
std::optional<Pose> RosCalibration::LeftFrom(const std::string& frame) const {
  const std::optional<RosPose> left = PoseInRoot(left_->frame);
  const std::optional<RosPose> other = PoseInRoot(frame);
  if (!left || !other || left->parent != other->parent) return std::nullopt;
  return left->parent_from_child.Inverse() * other->parent_from_child;
}

// The frame of the range sensor.
const std::string& RosCalibration::RangeFrame() const {
  return points_frame_ ? *points_frame_ : depth_->frame;
}

// Where the range sensor stands in the left image's frame.
std::optional<Pose> RosCalibration::LeftFromRange() const {
  return settings_.left_from_range ? settings_.left_from_range : LeftFrom(RangeFrame());
}

std::optional<RosRole> RosCalibration::Missing() const {
  if (!left_) return RosRole::kLeftInfo;
  if (!right_) return RosRole::kRightInfo;
  if (!settings_.points.empty() && !points_frame_) return RosRole::kPoints;
  if (!settings_.depth.empty() && !depth_) return RosRole::kDepthInfo;
  const bool is_registered =
      !settings_.depth.empty() &&
      (settings_.depth_info == settings_.left_info || settings_.depth_info == settings_.right_info);
  const bool has_range = points_frame_ || depth_;
  if (has_range && !is_registered && !LeftFromRange()) return RosRole::kTf;
  return std::nullopt;
}

std::string RosCalibration::MissingTransform() const {
  constexpr size_t kMaxListed = 20;
  std::string text = "no transform from the range sensor's frame '" + RangeFrame() +
                     "' to the left camera's '" + left_->frame + "' on";
  for (const std::string& topic : settings_.TopicsOf(RosRole::kTf)) text += " " + topic;
  text += "; transforms there:";
  size_t count = 0;
  for (const auto& [child, pose] : poses_) {
    if (++count <= kMaxListed) text += " " + pose.parent + " > " + child;
  }
  if (count == 0) text += " none";
  if (count > kMaxListed) text += " and " + std::to_string(count - kMaxListed) + " more";
  if (!unusable_.empty()) text += "; not usable (no rotation, or not finite):";
  for (const std::string& child : unusable_) text += " " + child;
  if (!moved_.empty()) text += "; of several parents the newest counts:";
  for (const std::string& child : moved_) text += " " + child;
  return text + "; allowed: tf=TOPIC, or pose=x,y,z,qx,qy,qz,qw of the range sensor";
}

Result<TofCamera> RosCalibration::DepthCamera(const RectifiedPair& pair) const {
  const RosCamera& camera = depth_->camera;
  const bool is_rectified = settings_.DepthIsRectified();
  if (!is_rectified && !camera.lens) {
    return Fail(settings_.depth_info + ": " + camera.lens.error().text);
  }
  const Lens lens = is_rectified ? camera.RectifiedLens() : *camera.lens;
  Pose pose;
  if (settings_.depth_info == settings_.right_info) {
    pose.translation_m.x() = pair.baseline_m;
  } else if (settings_.depth_info != settings_.left_info) {
    const Pose left_from_depth = *LeftFromRange();
    const Eigen::Quaterniond turn = TurnOf(left_->camera);
    pose.rotation = turn * left_from_depth.rotation;
    pose.translation_m = turn * left_from_depth.translation_m;
    if (is_rectified) pose.rotation = pose.rotation * TurnOf(camera).conjugate();
  }
  return TofCameraOf(lens, pose);
}

Result<RosRig> RosCalibration::Rig() const {
  const Result<RectifiedPair> pair = PairOf(left_->camera, right_->camera);
  if (!pair) return tl::unexpected(pair.error());
  RosRig rig{.rig = {.pair = *pair, .tof = {}}};
  // P holds f·b; the baseline itself may be in /tf_static, without the error of the division.
  if (const std::optional<Pose> right = LeftFrom(right_->frame)) {
    const double baseline_m = right->translation_m.x();
    if (std::abs(baseline_m - pair->baseline_m) < 1e-12) rig.rig.pair.baseline_m = baseline_m;
  }
  if (points_frame_) {
    const Pose pose = *LeftFromRange();
    rig.left_from_points =
        TurnOf(left_->camera) * (Eigen::Translation3d(pose.translation_m) * pose.rotation);
    rig.rig.tof = scenes::TofGridCamera(rig.rig.pair, 1);
  } else if (depth_) {
    const Result<TofCamera> tof = DepthCamera(rig.rig.pair);
    if (!tof) return tl::unexpected(tof.error());
    rig.rig.tof = *tof;
  }
  if (const Result<void> usable = CheckRig(rig.rig); !usable) return tl::unexpected(usable.error());
  return rig;
}

Result<bool> RosRigWatch::Take(const RosBytes& message) {
  const Result<bool> changed = calibration_.Take(message);
  const bool is_info = message.role == RosRole::kLeftInfo || message.role == RosRole::kRightInfo ||
                       message.role == RosRole::kDepthInfo;
  if (!changed) {
    if (is_info) refused_[message.role] = changed.error().text;
    return tl::unexpected(changed.error());
  }
  refused_.erase(message.role);
  if (!*changed) return false;
  if (calibration_.Missing()) {
    misfit_ = calibration_.MissingTransform();
    return false;
  }
  Result<RosRig> rig = calibration_.Rig();
  misfit_ = rig ? "" : rig.error().text;
  if (!rig || AreEqual(*rig, rig_)) return false;
  rig_ = std::move(*rig);
  is_new_ = true;
  return true;
}

std::string RosRigWatch::trouble() const {
  return refused_.empty() ? misfit_ : refused_.begin()->second;
}

std::optional<RosRig> RosRigWatch::TakeNewRig(int64_t utime) {
  const int64_t changed = calibration_.changed_utime();
  const bool is_from_before = utime < changed && utime > changed - kMaxOvertakenUs;
  if (!is_new_ || is_from_before) return std::nullopt;
  is_new_ = false;
  return rig_;
}

}  // namespace sprout::capture
