#pragma once

#include <algorithm>

#include "common/core/pose.h"

namespace sprout {

/// A pose as messages have it: quaternion w, x, y, z; translation, m.
inline void FillPose(const Pose& pose, double (&rotation)[4], double (&translation_m)[3]) {
  rotation[0] = pose.rotation.w();
  rotation[1] = pose.rotation.x();
  rotation[2] = pose.rotation.y();
  rotation[3] = pose.rotation.z();
  std::copy(pose.translation_m.begin(), pose.translation_m.end(), translation_m);
}

/// The inverse, unchecked.
inline Pose PoseOf(const double (&rotation)[4], const double (&translation_m)[3]) {
  return {Eigen::Quaterniond(rotation[0], rotation[1], rotation[2], rotation[3]),
          Eigen::Vector3d(translation_m)};
}

}  // namespace sprout
