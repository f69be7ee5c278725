#include "services/depth/cloud.h"

#include <cassert>
#include <cmath>
#include <cstdint>
#include <unordered_set>

#include "common/geometry/projection.h"

namespace sprout::depth {
namespace {

// Remembers which cubes have a point; says so of one point after the other.
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

cv::Vec3b ColourAt(const cv::Mat& image, int u, int v) {
  if (image.channels() == 3) return image.at<cv::Vec3b>(v, u);
  return cv::Vec3b::all(image.at<uint8_t>(v, u));
}

}  // namespace

PointCloud CloudOf(const DisparityImage& disparity, const RectifiedPair& pair, const cv::Mat& left,
                   const cv::Mat& confidence, const CloudThinning& thinning) {
  assert(left.size() == disparity.size() && disparity.size() == pair.size());
  assert(confidence.empty() || confidence.size() == disparity.size());
  // Beyond, a float of millimetres would be none, and a voxel's number no integer.
  constexpr double kFarthestM = 1e6;
  PointCloud cloud;
  VoxelFilter filter(thinning.voxel_m);
  for (int v = 0; v < disparity.height(); v += thinning.stride) {
    for (int u = 0; u < disparity.width(); u += thinning.stride) {
      if (!disparity.IsValid(u, v)) continue;
      const Eigen::Vector3d point = PointAt(pair, disparity, u, v);
      if (!(point.z() > 0) || !(point.norm() < kFarthestM) || !filter.IsFirst(point)) continue;
      if (cloud.points.size() == kMaxCloudPoints) return cloud;
      cloud.points.push_back(
          {.position_m = {static_cast<float>(point.x()), static_cast<float>(point.y()),
                          static_cast<float>(point.z())},
           .bgr = ColourAt(left, u, v),
           .confidence = confidence.empty() ? uint8_t{255} : confidence.at<uint8_t>(v, u)});
    }
  }
  return cloud;
}

}  // namespace sprout::depth
