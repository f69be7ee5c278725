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

/// Index of a disparity in the result of TableOf().
inline size_t IndexOf(int16_t counts) {
  return static_cast<size_t>(counts - int{DisparityImage::kInvalid});
}

/// of(disparity, px) for every disparity that a map can have; 0 for none. O(65536).
template <typename Number, typename Of>
std::vector<Number> TableOf(const Of& of) {
  std::vector<Number> table(size_t{1} << 16, 0);
  for (size_t i = 1; i < table.size(); ++i) {  // 0: DisparityImage::kInvalid
    const double counts = static_cast<double>(i) + double{DisparityImage::kInvalid};
    table[i] = of(counts / DisparityImage::kCountsPerPixel);
  }
  return table;
}

/// Depth z of every disparity that a map can have, m; 0 for none, and where z is not positive or
/// beyond 1000 km.
class DepthOfCounts {
 public:
  explicit DepthOfCounts(const RectifiedPair& pair)
      : depth_m_(TableOf<float>([&](double disparity_px) {
          constexpr double kMaxDepthM = 1e6;
          const double z = pair.DepthFromDisparity(disparity_px);
          return z > 0 && z < kMaxDepthM ? static_cast<float>(z) : 0.0F;
        })) {}

  float operator()(int16_t counts) const { return depth_m_[IndexOf(counts)]; }

 private:
  std::vector<float> depth_m_;
};

}  // namespace sprout::depth
