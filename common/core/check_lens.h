#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>

#include "common/core/checks.h"
#include "common/core/pose.h"
#include "common/core/rig.h"

namespace sprout {

/// Whether these numbers are possible for a camera: a focal length of 0.05 to 50 times its longest
/// side (fields of view of 169° and 1°), a principal point within ten sides, distortion that moves
/// no pixel by more than ten times its distance from the principal point. These bounds keep
/// computations valid and are far beyond real cameras.
/// @param prefix  of the names of the fields, "tof_" or "left.".
void CheckLens(Checks& checks, const std::string& prefix, const Lens& lens);

/// Whether this position is possible for a camera: at most 1 km away on each axis.
void CheckDistance(Checks& checks, const std::string& field, const Eigen::Vector3d& metres);

/// A rotation of norm 1, a finite translation.
/// @param name  of the fields without _rotation and _translation_m.
inline void CheckPoseFields(Checks& checks, const std::string& name, const Pose& pose) {
  const double norm = pose.rotation.norm();
  checks.Require(std::abs(norm - 1) < 1e-6, (name + "_rotation norm").c_str(), norm, "1");
  for (const double value : pose.translation_m) {
    checks.Finite((name + "_translation_m").c_str(), value);
  }
}

}  // namespace sprout
