#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <unordered_set>

#include "common/core/depth_image.h"
#include "common/core/disparity_image.h"
#include "common/core/pose.h"
#include "common/core/rig.h"

namespace sprout::depth {

/// Remembers which cubes have a point; says so of one point after the other.
class VoxelFilter {
 public:
  /// @param side_m  0: all points; less than a micrometre counts as one.
  explicit VoxelFilter(double side_m) : side_m_(side_m > 0 ? std::max(side_m, 1e-6) : 0) {}

  bool IsFirst(const Eigen::Vector3d& point) {
    if (side_m_ == 0) return true;
    return taken_.insert({Index(point.x()), Index(point.y()), Index(point.z())}).second;
  }

 private:
  struct Voxel {
    int64_t x, y, z;
    bool operator==(const Voxel&) const = default;
  };

  struct Hash {
    // Teschner et al., "Optimized Spatial Hashing", VMV 2003.
    size_t operator()(const Voxel& v) const {
      const auto part = [](int64_t index, uint64_t prime) {  // modulo 2^64
        return static_cast<uint64_t>(index) * prime;
      };
      return part(v.x, 73856093) ^ part(v.y, 19349663) ^ part(v.z, 83492791);
    }
  };

  int64_t Index(double coordinate_m) const {
    return static_cast<int64_t>(std::floor(coordinate_m / side_m_));
  }

  double side_m_;
  std::unordered_set<Voxel, Hash> taken_;
};

/// How a cloud is thinned.
struct CloudThinning {
  int stride = 1;      ///< N: every N-th pixel of every N-th row
  double voxel_m = 0;  ///< keeps the first point in each cube of this side; 0 = all
};

/// Points of a disparity map, row by row, with the colours of the left image. Pixels without a
/// disparity, or without a finite positive depth, give none. At most kMaxCloudPoints. O(pixels /
/// stride²).
///
/// @param left        8UC1 or 8UC3 (BGR), of the map's size.
/// @param confidence  8UC1 of the map's size, or empty: 255 everywhere.
PointCloud CloudOf(const DisparityImage& disparity, const RectifiedPair& pair, const cv::Mat& left,
                   const cv::Mat& confidence, const CloudThinning& thinning);

/// The same points in another frame. O(points).
PointCloud Moved(PointCloud cloud, const Pose& other_from_left);

/// A point with the colour and the confidence of a pixel.
/// @param left, confidence  as for CloudOf(), of a size that has the pixel.
CloudPoint CloudPointOf(const Eigen::Vector3d& position_m, const cv::Mat& left,
                        const cv::Mat& confidence, cv::Point pixel);

}  // namespace sprout::depth
