#pragma once

#include <Eigen/Geometry>

namespace sprout {

/// Pose of one camera in the frame of another one, or in its own of another time: point_in_other =
/// rotation · point_in_camera + translation_m. Its layout does not depend on Eigen's vectorisation.
struct Pose {
  Eigen::Quaternion<double, Eigen::DontAlign> rotation =
      Eigen::Quaternion<double, Eigen::DontAlign>::Identity();
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();

  /// The pose b_from_a for a pose a_from_b.
  Pose Inverse() const {
    const auto back = rotation.conjugate();
    return {back, -(back * translation_m)};
  }
  /// a_from_b * b_from_c = a_from_c. The rotation stays of norm 1.
  Pose operator*(const Pose& other) const {
    return {(rotation * other.rotation).normalized(),
            rotation * other.translation_m + translation_m};
  }
  bool operator==(const Pose&) const = default;
};

}  // namespace sprout
