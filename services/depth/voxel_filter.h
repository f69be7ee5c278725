#ifndef SPROUT_SERVICES_DEPTH_VOXEL_FILTER_H_
#define SPROUT_SERVICES_DEPTH_VOXEL_FILTER_H_

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_set>

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

}  // namespace sprout::depth

#endif  // SPROUT_SERVICES_DEPTH_VOXEL_FILTER_H_
