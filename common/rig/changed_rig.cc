#include "common/rig/changed_rig.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "common/core/checks.h"

namespace sprout {
namespace {

double DegreesBetween(const Pose& a, const Pose& b) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  return kDegrees * Eigen::Quaterniond(a.rotation).angularDistance(Eigen::Quaterniond(b.rotation));
}

}  // namespace

RawRig ChangedRig(const RawRig& rig, const Rectification& made, const RigChange& change) {
  const Eigen::Matrix3d left_from_rectified = BackOf(made.left_turn);
  RawRig changed = rig;
  changed.left_from_right = TurnedBy(rig.left_from_right, left_from_rectified * change.right.turn);
  if (rig.tof.width == 0) return changed;
  changed.left_from_tof = TurnedBy(rig.left_from_tof, left_from_rectified * change.tof.turn);
  changed.range_offset_m += change.range_offset_m;
  return changed;
}

Result<void> CheckLimits(const RawRig& rig, const RawRig& board,
                         const SelfCalibrationLimits& limits) {
  constexpr double kMm = 1000;
  constexpr const char* kAdvice =
      "from the board's calibration (self_calibration of the rig file); "
      "beyond: calibrate with the board";
  const auto within = [&](Checks& checks, const char* what, double value, double most,
                          const char* unit) {
    checks.Within(what, value, 0, most, (std::string(unit) + " " + kAdvice).c_str());
  };
  Checks checks;
  within(checks, "turn of the right camera",
         DegreesBetween(rig.left_from_right, board.left_from_right), limits.turn_deg(), "degrees");
  within(checks, "turn of the ToF camera", DegreesBetween(rig.left_from_tof, board.left_from_tof),
         limits.tof_turn_deg(), "degrees");
  within(checks, "change of the ranges", kMm * std::abs(rig.range_offset_m - board.range_offset_m),
         limits.range_mm(), "mm");
  if (!checks.ok()) return checks.error();
  return {};
}

}  // namespace sprout
