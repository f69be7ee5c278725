#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/core/disparity_image.h"
#include "common/core/pose.h"
#include "common/core/rig.h"

namespace sprout::depth {

/// Points of the left image's pixels in another frame: a row of pixels of one depth is a straight
/// line there, which saves a rotation a pixel.
struct Rays {
  Rays(const RectifiedPair& pair, const Pose& other_from_left)
      : origin(other_from_left.translation_m) {
    const Eigen::Matrix3d rotation = other_from_left.rotation.toRotationMatrix();
    per_u = rotation.col(0) / pair.focal_px;
    per_v = rotation.col(1) / pair.focal_px;
    corner = rotation.col(2) - pair.cx * per_u - pair.cy * per_v;
  }

  /// Direction of pixel (0, v); that of (u, v) is u · per_u farther.
  Eigen::Vector3d RowStart(double v) const { return corner + v * per_v; }
  Eigen::Vector3d Direction(double u, double v) const { return RowStart(v) + u * per_u; }

  Eigen::Vector3d origin;  ///< of the left camera, m
  Eigen::Vector3d corner;  ///< direction of pixel (0, 0), with a depth of 1 along the left axis
  Eigen::Vector3d per_u;
  Eigen::Vector3d per_v;
};

/// Depth z of every disparity that a map can have, m; 0 for none, and where z is not positive or
/// beyond 1000 km. O(65536).
class DepthOfCounts {
 public:
  explicit DepthOfCounts(const RectifiedPair& pair) : depth_m_(size_t{1} << 16, 0.0F) {
    constexpr double kFarthestM = 1e6;
    for (size_t i = 1; i < depth_m_.size(); ++i) {  // 0: DisparityImage::kInvalid
      const double counts = static_cast<double>(i) + double{DisparityImage::kInvalid};
      const double z = pair.DepthFromDisparity(counts / DisparityImage::kCountsPerPixel);
      if (z > 0 && z < kFarthestM) depth_m_[i] = static_cast<float>(z);
    }
  }

  float operator()(int16_t counts) const {
    return depth_m_[static_cast<size_t>(counts - int{DisparityImage::kInvalid})];
  }

 private:
  std::vector<float> depth_m_;
};

}  // namespace sprout::depth
