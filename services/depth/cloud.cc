#include "services/depth/cloud.h"

#include <cassert>

#include "common/geometry/projection.h"

namespace sprout::depth {

CloudPoint CloudPointOf(const Eigen::Vector3d& position_m, const cv::Mat& left,
                        const cv::Mat& confidence, cv::Point pixel) {
  return {.position_m = {static_cast<float>(position_m.x()), static_cast<float>(position_m.y()),
                         static_cast<float>(position_m.z())},
          .bgr = left.channels() == 3 ? left.at<cv::Vec3b>(pixel)
                                      : cv::Vec3b::all(left.at<uint8_t>(pixel)),
          .confidence = confidence.empty() ? uint8_t{255} : confidence.at<uint8_t>(pixel)};
}

PointCloud Moved(PointCloud cloud, const Pose& other_from_left) {
  const Eigen::Matrix3d rotation = other_from_left.rotation.toRotationMatrix();
  for (CloudPoint& point : cloud.points) {
    cv::Point3f& p = point.position_m;
    const Eigen::Vector3d moved =
        rotation * Eigen::Vector3d(double{p.x}, double{p.y}, double{p.z}) +
        other_from_left.translation_m;
    p = {static_cast<float>(moved.x()), static_cast<float>(moved.y()),
         static_cast<float>(moved.z())};
  }
  return cloud;
}

PointCloud CloudOf(const DisparityImage& disparity, const RectifiedPair& pair, const cv::Mat& left,
                   const cv::Mat& confidence, const CloudThinning& thinning) {
  assert(left.size() == disparity.size() && disparity.size() == pair.size());
  assert(confidence.empty() || confidence.size() == disparity.size());
  // Farther points are left out: a float cannot hold their millimetres, nor an integer their voxel.
  constexpr double kMaxDistanceM = 1e6;
  PointCloud cloud;
  VoxelFilter filter(thinning.voxel_m);
  for (int v = 0; v < disparity.height(); v += thinning.stride) {
    for (int u = 0; u < disparity.width(); u += thinning.stride) {
      if (!disparity.IsValid(u, v)) continue;
      const Eigen::Vector3d point = PointAt(pair, disparity, u, v);
      if (!(point.z() > 0) || !(point.norm() < kMaxDistanceM) || !filter.IsFirst(point)) continue;
      if (cloud.points.size() == kMaxCloudPoints) return cloud;
      cloud.points.push_back(CloudPointOf(point, left, confidence, {u, v}));
    }
  }
  return cloud;
}

}  // namespace sprout::depth
