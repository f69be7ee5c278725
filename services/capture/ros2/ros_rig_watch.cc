#include "services/capture/ros2/ros_rig_watch.h"

#include <utility>

namespace sprout::capture {
namespace {

// How much older a frame may be that comes behind the CameraInfo of a later one, µs.
constexpr int64_t kMaxOvertakenUs = 1'000'000;

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

}  // namespace

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
    misfit_ = "no transform from the range sensor to the left camera any more";
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
