#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/core/types.hpp>
#include <string>

#include "common/core/result.h"

namespace sprout {

/// The rectified stereo pair: two pinhole cameras with the same focal length, row of the principal
/// point and orientation, the right one baseline_m to the right of the left one.
struct RectifiedPair {
  int width = 0;          ///< px, of either image
  int height = 0;         ///< px, of either image
  double focal_px = 0;    ///< focal length, px
  double cx = 0;          ///< principal point of the left camera, px
  double cy = 0;          ///< principal point of both cameras, px
  double cx_right = 0;    ///< principal point of the right camera, px
  double baseline_m = 0;  ///< distance of the optical centres, m

  cv::Size size() const { return {width, height}; }

  /// Depth z of a disparity d: z = f·b / (d + cx_right − cx), m. The disparity of a point at
  /// infinity is cx − cx_right, so the result is meaningful above that only.
  double DepthFromDisparity(double disparity_px) const {
    return focal_px * baseline_m / (disparity_px + cx_right - cx);
  }

  /// Standard deviation of that depth, m, to first order in that of the disparity:
  /// σ_z = z² / (f·b) · σ_d (services/depth/README.md, D1).
  double DepthSigma(double disparity_px, double sigma_px) const {
    const double z = DepthFromDisparity(disparity_px);
    return z * z / (focal_px * baseline_m) * sigma_px;
  }

  /// Disparity of a depth z > 0, px: the inverse of DepthFromDisparity().
  double DisparityFromDepth(double depth_m) const {
    return focal_px * baseline_m / depth_m + cx - cx_right;
  }
};

/// A camera that is not rectified: pinhole and Brown's lens distortion.
struct Lens {
  int width = 0;   ///< px
  int height = 0;  ///< px
  double fx = 0;   ///< focal lengths, px
  double fy = 0;
  double cx = 0;  ///< principal point, px
  double cy = 0;
  std::array<double, 5> distortion{};  ///< k1, k2, p1, p2, k3 (OpenCV's order)

  cv::Size size() const { return {width, height}; }
};

/// The ToF camera: pinhole, Brown's lens distortion, pose in the left rectified frame. The layout
/// of its members does not depend on Eigen's vectorisation.
struct TofCamera {
  int width = 0;   ///< px; 0 = there is no ToF camera
  int height = 0;  ///< px; 0 = there is no ToF camera
  double fx = 0;   ///< focal lengths, px
  double fy = 0;
  double cx = 0;  ///< principal point, px
  double cy = 0;
  std::array<double, 5> distortion{};  ///< k1, k2, p1, p2, k3 (OpenCV's order)
  /// Rotation and position (m) of the ToF camera in the left rectified frame (x right, y down,
  /// z forward): point_in_left = rotation · point_in_tof + translation.
  Eigen::Quaternion<double, Eigen::DontAlign> left_from_tof_rotation =
      Eigen::Quaternion<double, Eigen::DontAlign>::Identity();
  Eigen::Vector3d left_from_tof_translation_m = Eigen::Vector3d::Zero();

  Lens lens() const { return {width, height, fx, fy, cx, cy, distortion}; }
};

/// Calibration of the whole rig.
struct Rig {
  RectifiedPair pair;
  TofCamera tof;
};

/// Whether a calibration can be used: finite numbers, lengths > 0, images of at most kMaxSide and
/// kMaxPixels, a rotation of norm 1. The error names the first wrong field, by its name in
/// rig_t.lcm.
Result<void> CheckRig(const Rig& rig);

/// Digest of a calibration: 16 hexadecimal digits, equal for equal numbers on every machine.
std::string RigId(const Rig& rig);

}  // namespace sprout
