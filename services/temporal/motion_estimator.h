#pragma once

#include <Eigen/Core>
#include <span>

#include "common/core/camera_motion.h"
#include "common/core/rig.h"

namespace sprout::temporal {

/// A scene point that was seen in two successive images.
struct SeenPoint {
  Eigen::Vector3d before_m;  ///< in the left camera's frame then
  Eigen::Vector2d after_px;  ///< in the left image now
};

/// When a motion is believed.
struct MotionRule {
  double inlier_px = 1;  ///< largest reprojection error of an inlier
  int min_inliers = 20;
  double min_inlier_share = 0.3;
};

/// The left camera's frame then, seen from now.
struct MotionEstimate {
  Pose left_from_last;
  Eigen::Matrix<double, 6, 6> covariance;  ///< rotation vector (rad), translation (m)
  int inliers = 0;
  MemoryReset reset = MemoryReset::kNone;  ///< or why the motion is not known
};

/// The motion that most points agree with, (T2). Candidates are standing still,
/// going on as before, and 200 motions from three points each, drawn in a fixed order (Fischler and
/// Bolles, CACM 1981). A later candidate must have 10 % more inliers than the best one before it:
/// then a standing camera stands still, whatever moves in front of it. The winner is refined on its
/// inliers, twice. A pure function; about 1 ms for 600 points.
/// @param as_before  the last motion.
MotionEstimate EstimateMotion(std::span<const SeenPoint> points, const RectifiedPair& pair,
                              const Pose& as_before, const MotionRule& rule);

}  // namespace sprout::temporal
