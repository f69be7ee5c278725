#ifndef SPROUT_COMMON_CORE_POSE_CHECKS_H_
#define SPROUT_COMMON_CORE_POSE_CHECKS_H_

#include <cmath>
#include <string>

#include "common/core/checks.h"
#include "common/core/pose.h"

namespace sprout {

/// A rotation of norm 1, a finite translation.
/// @param name  of the fields without _rotation and _translation_m.
inline void CheckPoseFields(Checks& checks, const std::string& name, const Pose& pose) {
  const auto& q = pose.rotation;
  const double norm = std::sqrt(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
  checks.Require(std::abs(norm - 1) < 1e-6, (name + "_rotation norm").c_str(), norm, "1");
  for (const double value : pose.translation_m) {
    checks.Finite((name + "_translation_m").c_str(), value);
  }
}

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_POSE_CHECKS_H_
