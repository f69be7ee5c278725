#include "common/geometry/projection.h"

#include <cassert>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <utility>

namespace sprout {

Seed ProjectToPair(const RectifiedPair& pair, const Eigen::Vector3d& point_in_left) {
  const double scale = pair.focal_px / point_in_left.z();
  return {
      .u = static_cast<float>(scale * point_in_left.x() + pair.cx),
      .v = static_cast<float>(scale * point_in_left.y() + pair.cy),
      .u_right = static_cast<float>(scale * (point_in_left.x() - pair.baseline_m) + pair.cx_right)};
}

Eigen::Vector3d PointFromSeed(const RectifiedPair& pair, const Seed& seed) {
  const double z = pair.DepthFromDisparity(seed.disparity());
  return {(seed.u - pair.cx) * z / pair.focal_px, (seed.v - pair.cy) * z / pair.focal_px, z};
}

TofProjector::TofProjector(const Rig& rig) : rig_(rig) {
  const TofCamera& tof = rig.tof;
  std::vector<cv::Point2d> pixels;
  pixels.reserve(static_cast<size_t>(tof.width) * static_cast<size_t>(tof.height));
  for (int v = 0; v < tof.height; ++v) {
    for (int u = 0; u < tof.width; ++u) pixels.emplace_back(u, v);
  }
  std::vector<cv::Point2d> undistorted;
  const cv::Matx33d camera(tof.fx, 0, tof.cx, 0, tof.fy, tof.cy, 0, 0, 1);
  // More iterations than OpenCV's five: wide lenses need them, and it is done once a calibration.
  cv::undistortPoints(pixels, undistorted, camera,
                      std::vector<double>(tof.distortion.begin(), tof.distortion.end()),
                      cv::noArray(), cv::noArray(),
                      cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-12));
  rays_.reserve(undistorted.size());
  for (const cv::Point2d& p : undistorted) rays_.emplace_back(p.x, p.y, 1.0);
}

std::vector<ProjectedPoint> TofProjector::Project(const TofImage& tof, int& behind,
                                                  std::vector<ProjectedPoint> memory) const {
  assert(tof.depth_m.cols == rig_.tof.width && tof.depth_m.rows == rig_.tof.height);
  const Eigen::Matrix3d rotation = rig_.tof.left_from_tof_rotation.toRotationMatrix();
  behind = 0;
  std::vector<ProjectedPoint> points = std::move(memory);
  points.clear();
  points.reserve(tof.depth_m.total());
  for (int v = 0; v < tof.depth_m.rows; ++v) {
    for (int u = 0; u < tof.depth_m.cols; ++u) {
      const float depth_m = tof.depth_m(v, u);
      if (!std::isfinite(depth_m) || depth_m <= 0) continue;
      const Eigen::Vector3d point_in_tof = depth_m * ray(u, v);
      const Eigen::Vector3d point_in_left =
          rotation * point_in_tof + rig_.tof.left_from_tof_translation_m;
      if (point_in_left.z() > 0) {
        points.push_back({u, v, ProjectToPair(rig_.pair, point_in_left)});
      } else {
        ++behind;
      }
    }
  }
  return points;
}

}  // namespace sprout
