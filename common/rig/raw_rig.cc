#include "common/rig/raw_rig.h"

#include <cmath>
#include <string>

#include "common/core/checks.h"

namespace sprout {
namespace {

// A quaternion that was written with seven digits is still one.
constexpr double kUnitTolerance = 1e-6;

void CheckLens(Checks& checks, const std::string& name, const Lens& lens) {
  const auto field = [&](const char* of_lens) { return name + "." + of_lens; };
  checks.Side(field("width").c_str(), lens.width)
      .Side(field("height").c_str(), lens.height)
      .Pixels((field("width") + " × height").c_str(), lens.width, lens.height)
      .Positive(field("fx").c_str(), lens.fx)
      .Positive(field("fy").c_str(), lens.fy)
      .Finite(field("cx").c_str(), lens.cx)
      .Finite(field("cy").c_str(), lens.cy);
  for (double value : lens.distortion) checks.Finite(field("distortion").c_str(), value);
}

void CheckPose(Checks& checks, const std::string& name, const Pose& pose) {
  const double norm = pose.rotation.coeffs().norm();
  checks.Require(std::abs(norm - 1) < kUnitTolerance, (name + ".rotation norm").c_str(), norm,
                 "1 (a unit quaternion)");
  for (double value : pose.translation_m) checks.Finite((name + ".translation_m").c_str(), value);
}

}  // namespace

Result<void> CheckRawRig(const RawRig& rig) {
  Checks checks;
  CheckLens(checks, "left", rig.left);
  CheckLens(checks, "right", rig.right);
  checks.Require(rig.right.size() == rig.left.size(), "right.width × height",
                 SizeText(rig.right.size()), "the left camera's " + SizeText(rig.left.size()));
  checks.Require(rig.left.width >= 2 && rig.left.height >= 2, "left.width × height",
                 SizeText(rig.left.size()), "2x2 or more");
  CheckPose(checks, "left_from_right", rig.left_from_right);
  checks.Positive("left_from_right.translation_m x", rig.left_from_right.translation_m.x());
  if (rig.tof.width > 0 || rig.tof.height > 0) {
    CheckLens(checks, "tof", rig.tof);
    CheckPose(checks, "left_from_tof", rig.left_from_tof);
  }
  checks.Positive("range_scale", rig.range_scale).Finite("range_offset_m", rig.range_offset_m);
  if (!checks.ok()) return checks.error();
  return {};
}

}  // namespace sprout
