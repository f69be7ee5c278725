#include "common/rig/raw_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/check_lens.h"
#include "common/geometry/lens.h"
#include "common/rig/rectification.h"

namespace sprout {
namespace {

// A quaternion that was written with seven digits is still one.
constexpr double kUnitTolerance = 1e-6;

constexpr double kMinBaselineM = 1e-4;  // as of a rectified pair
constexpr double kMaxAngleDeg = 60;
// Least shares of what both cameras see. A pair of equal lenses that look into one direction has
// 0.75 and more.
constexpr double kMinRows = 0.3;
constexpr double kMinKept = 0.1;
constexpr double kMinFilled = 0.9;

// How far the pixels of a coarse grid are off, px, when their distortion is undone and done again.
double WorstReturn(const Lens& lens) {
  constexpr int kSteps = 8;
  double worst_px = 0;
  for (int row = 0; row <= kSteps; ++row) {
    for (int column = 0; column <= kSteps; ++column) {
      const Eigen::Vector2d pixel((lens.width - 1.0) * column / kSteps,
                                  (lens.height - 1.0) * row / kSteps);
      const Eigen::Vector2d again = PixelOfDirection(lens, DirectionOfPixel(lens, pixel));
      const double off_px = (again - pixel).norm();
      if (!std::isfinite(off_px)) return off_px;
      worst_px = std::max(worst_px, off_px);
    }
  }
  return worst_px;
}

// What rectification makes of a pair whose numbers are those of cameras.
void CheckPair(Checks& checks, const RawRig& rig) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const Eigen::Quaterniond turn(rig.left_from_right.rotation);
  checks.Within("left_from_right.rotation: angle between the cameras",
                kDegrees * turn.angularDistance(Eigen::Quaterniond::Identity()), 0, kMaxAngleDeg,
                "degrees");
  if (!checks.ok()) return;
  const Rectification made = RectificationOf(rig);
  const double least_cos = std::min(made.left_turn(2, 2), made.right_turn(2, 2));
  checks.Within("left_from_right: angle between a camera and the normal to the baseline",
                kDegrees * std::acos(std::clamp(least_cos, -1.0, 1.0)), 0, kMaxAngleDeg, "degrees");
  if (!checks.ok()) return;
  const RectifiedViews views = ViewsOf(rig, made);
  const char* const unit = "% (do both cameras look at one scene, through the same lenses?)";
  checks
      .Within("left_from_right: vertical overlap of the rectified views", 100 * views.rows,
              100 * kMinRows, 100, unit)
      .Within("left, right: what rectification keeps of a camera's image", 100 * views.kept,
              100 * kMinKept, 100, unit)
      .Within("left, right: what a camera sees of its rectified image", 100 * views.filled,
              100 * kMinFilled, 100, unit);
  // What goes on the bus has to be taken there.
  const Result<void> rectified = CheckRig({.pair = made.pair, .tof = {}});
  checks.Require(rectified.has_value(), "left_from_right", "a pair that cannot be rectified",
                 rectified ? "" : "one with rectified " + rectified.error().text);
}

}  // namespace

TofCamera TofCameraOf(const Lens& lens, const Pose& left_from_tof) {
  return {.width = lens.width,
          .height = lens.height,
          .fx = lens.fx,
          .fy = lens.fy,
          .cx = lens.cx,
          .cy = lens.cy,
          .distortion = lens.distortion,
          .left_from_tof_rotation = left_from_tof.rotation,
          .left_from_tof_translation_m = left_from_tof.translation_m};
}

Pose TurnedBy(const Pose& pose, const Eigen::Vector3d& turn) {
  if (turn.isZero(0)) return pose;
  const Eigen::Quaterniond by(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  return {.rotation = (by * Eigen::Quaterniond(pose.rotation)).normalized(),
          .translation_m = pose.translation_m};
}

void CheckCamera(Checks& checks, const std::string& name, const Lens& lens) {
  CheckLens(checks, name + ".", lens);
  if (!checks.ok()) return;
  const double allowed_px = std::max(1.0, 0.01 * std::max(lens.width, lens.height));
  const double off_px = WorstReturn(lens);
  checks.Require(
      off_px <= allowed_px,
      (name + ".distortion: pixels that move when it is removed and applied again, by").c_str(),
      off_px, "up to " + std::to_string(std::lround(allowed_px)) + " px (it folds the image over)");
}

void CheckPose(Checks& checks, const std::string& name, const Pose& pose) {
  const double norm = pose.rotation.coeffs().norm();
  checks.Require(std::abs(norm - 1) < kUnitTolerance, (name + ".rotation norm").c_str(), norm,
                 "1 (a unit quaternion)");
  CheckDistance(checks, name + ".translation_m", pose.translation_m);
}

Result<void> CheckRawRig(const RawRig& rig) {
  Checks checks;
  CheckCamera(checks, "left", rig.left);
  CheckCamera(checks, "right", rig.right);
  checks.Require(rig.right.size() == rig.left.size(), "right.width × height",
                 SizeText(rig.right.size()), "the left camera's " + SizeText(rig.left.size()));
  checks.Require(rig.left.width >= 2 && rig.left.height >= 2, "left.width × height",
                 SizeText(rig.left.size()), "2x2 or more");
  CheckPose(checks, "left_from_right", rig.left_from_right);
  const Eigen::Vector3d& place_m = rig.left_from_right.translation_m;
  // Cameras above each other would be rectified by their columns.
  checks.Require(
      std::abs(place_m.y()) <= std::abs(place_m.x()), "left_from_right.translation_m y",
      place_m.y(),
      "less than x; of cameras that stand above each other turn the images by 90 degrees");
  checks.Require(place_m.x() >= kMinBaselineM, "left_from_right.translation_m x", place_m.x(),
                 "0.0001 m or more: the right camera stands right of the left one");
  if (rig.tof.width > 0 || rig.tof.height > 0) {
    CheckCamera(checks, "tof", rig.tof);
    CheckPose(checks, "left_from_tof", rig.left_from_tof);
  }
  checks.Positive("range_scale", rig.range_scale).Finite("range_offset_m", rig.range_offset_m);
  CheckCorrection(checks, "range_correction", rig.range_correction);
  CheckCorrection(checks, "amplitude_correction", rig.amplitude_correction);
  if (checks.ok()) CheckPair(checks, rig);
  if (!checks.ok()) return checks.error();
  return {};
}

}  // namespace sprout
