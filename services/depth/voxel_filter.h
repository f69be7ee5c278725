#ifndef SPROUT_SERVICES_DEPTH_VOXEL_FILTER_H_
#define SPROUT_SERVICES_DEPTH_VOXEL_FILTER_H_

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <unordered_set>

namespace sprout::depth {

/// Remembers which cubes have a point; says so of one point after the other.
class VoxelFilter {
 public:
  explicit VoxelFilter(double side_m) : side_m_(side_m) {}

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
      return static_cast<size_t>(v.x * 73856093 ^ v.y * 19349663 ^ v.z * 83492791);
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
