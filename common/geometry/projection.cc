#include "common/geometry/projection.h"

#include <cassert>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "common/core/image.h"
#include "common/core/prior_map.h"

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

Eigen::Vector3d PointAt(const RectifiedPair& pair, const DisparityImage& map, int u, int v) {
  const auto column = static_cast<float>(u);
  return PointFromSeed(pair,
                       {.u = column, .v = static_cast<float>(v), .u_right = column - map.Px(u, v)});
}

namespace {

// A map of what value_at(u, v, px) gives where there is a disparity px beyond infinity; else NaN.
template <typename ValueAt>
cv::Mat1f MapOf(const RectifiedPair& pair, const DisparityImage& disparity,
                const ValueAt& value_at) {
  const double infinity_px = pair.cx - pair.cx_right;
  cv::Mat1f map(disparity.size(), std::numeric_limits<float>::quiet_NaN());
  for (int v = 0; v < disparity.height(); ++v) {
    for (int u = 0; u < disparity.width(); ++u) {
      const double px = double{disparity.Px(u, v)};
      if (px > infinity_px) map(v, u) = static_cast<float>(value_at(u, v, px));  // false for NaN
    }
  }
  return map;
}

}  // namespace

cv::Mat1f DepthMap(const RectifiedPair& pair, const DisparityImage& disparity) {
  return MapOf(pair, disparity, [&](int, int, double px) { return pair.DepthFromDisparity(px); });
}

cv::Mat1f DepthSigmaMap(const RectifiedPair& pair, const DisparityImage& disparity,
                        const cv::Mat1b& sigma) {
  assert(sigma.size() == disparity.size());
  return MapOf(pair, disparity, [&](int u, int v, double px) {
    return sigma(v, u) == kMaxSigmaCounts ? std::numeric_limits<double>::infinity()
                                          : pair.DepthSigma(px, double{SigmaToPx(sigma(v, u))});
  });
}

TofCamera Resized(TofCamera camera, cv::Size size) {
  const double scale_u = static_cast<double>(size.width) / camera.width;
  const double scale_v = static_cast<double>(size.height) / camera.height;
  camera.width = size.width;
  camera.height = size.height;
  camera.fx *= scale_u;
  camera.fy *= scale_v;
  camera.cx = (camera.cx + 0.5) * scale_u - 0.5;
  camera.cy = (camera.cy + 0.5) * scale_v - 0.5;
  return camera;
}

TofCamera TofOverLeft(const RectifiedPair& pair, cv::Size size) {
  TofCamera left;
  left.width = pair.width;
  left.height = pair.height;
  left.fx = left.fy = pair.focal_px;
  left.cx = pair.cx;
  left.cy = pair.cy;
  return Resized(left, size);
}

Rig RigOfFrame(const Rig& rig, const TofImage& tof) {
  Rig of_frame = rig;
  if (tof.depth_m.empty()) of_frame.tof = {};
  return of_frame;
}

Result<void> CheckTofSize(const Rig& rig, const TofImage& tof) {
  return CheckImageSize("ToF image", tof.depth_m.size(), {rig.tof.width, rig.tof.height});
}

TofProjector::TofProjector(const Rig& rig) : rig_(rig) {
  const TofCamera& tof = rig.tof;
  const cv::Matx33d camera(tof.fx, 0, tof.cx, 0, tof.fy, tof.cy, 0, 0, 1);
  const std::vector<double> distortion(tof.distortion.begin(), tof.distortion.end());
  // More iterations than OpenCV's five: wide lenses need them, and it is done once a calibration.
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-12);
  rays_.reserve(static_cast<size_t>(tof.width) * static_cast<size_t>(tof.height));
  std::vector<cv::Point2d> row(static_cast<size_t>(tof.width));
  std::vector<cv::Point2d> undistorted;
  for (int v = 0; v < tof.height; ++v) {
    for (size_t u = 0; u < row.size(); ++u) row[u] = {static_cast<double>(u), double(v)};
    cv::undistortPoints(row, undistorted, camera, distortion, cv::noArray(), cv::noArray(),
                        criteria);
    for (const cv::Point2d& p : undistorted) rays_.emplace_back(p.x, p.y, 1.0);
  }
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
      if (!IsReturn(depth_m)) continue;
      const Eigen::Vector3d point_in_tof = depth_m * ray(u, v);
      const Eigen::Vector3d point_in_left =
          rotation * point_in_tof + rig_.tof.left_from_tof_translation_m;
      if (point_in_left.z() > 0) {
        Seed seed = ProjectToPair(rig_.pair, point_in_left);
        seed.tof_u = static_cast<int16_t>(u);
        seed.tof_v = static_cast<int16_t>(v);
        points.push_back({u, v, seed});
      } else {
        ++behind;
      }
    }
  }
  return points;
}

}  // namespace sprout
