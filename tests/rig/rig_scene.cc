#include "tests/rig/rig_scene.h"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "common/geometry/lens.h"

namespace sprout {
namespace {

constexpr int kRaysPerSide = 2;
constexpr double kNoise = 2;            // grey levels
constexpr double kNearestFloorM = 1.6;  // depth of the floor at the bottom of the image

scenes::LensView ViewOf(const Lens& lens, const Pose& pose, int rays_per_side) {
  return {lens, pose.rotation, pose.translation_m, rays_per_side};
}

scenes::Vec3 ToVec3(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// Parameter at which a ray meets the nearest solid; infinity when it meets none.
double Nearest(const std::vector<scenes::Solid>& solids, const scenes::Ray& ray) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const scenes::Solid& solid : solids)
    nearest = std::min(nearest, scenes::Intersect(solid, ray));
  return nearest;
}

}  // namespace

RigScene::RigScene(const RawRig& rig, uint32_t seed)
    : rig_(rig),
      scene_(seed, kNearestFloorM * rig.left.height / (2 * rig.left.fy)),
      left_(ViewOf(rig.left, {}, kRaysPerSide)),
      right_(ViewOf(rig.right, rig.left_from_right, kRaysPerSide)),
      tof_(ViewOf(rig.tof, rig.left_from_tof, scenes::TofSamples::kPerSide)),
      sr4000_(TofCameraOf(rig.tof, rig.left_from_tof), Sr4000Config(), seed),
      range_per_depth_(RangePerDepth(rig.tof)) {}

cv::Mat RigScene::RenderImage(const scenes::LensView& view,
                              const std::vector<scenes::Solid>& solids, uint32_t noise) const {
  cv::Mat3f rays(view.size(), cv::Vec3f(0, 0, 0));
  view.Cast(solids, rig_.left.fx, [&](int x, int y, double, const scenes::Vec3& bgr) {
    rays(y, x) =
        cv::Vec3f(static_cast<float>(bgr.x), static_cast<float>(bgr.y), static_cast<float>(bgr.z));
  });
  cv::Mat3f image;
  cv::resize(rays, image, rig_.left.size(), 0, 0, cv::INTER_AREA);  // the mean of a pixel's rays
  cv::Mat3f grain(image.size());
  cv::RNG(noise).fill(grain, cv::RNG::NORMAL, 0, kNoise);
  cv::Mat bytes;
  cv::Mat(image + grain).convertTo(bytes, CV_8U);
  return bytes;
}

calibrate::RigImages RigScene::Render(int64_t step, uint32_t noise) const {
  const std::vector<scenes::Solid> solids = scene_.At(step);
  calibrate::RigImages images{
      .left = RenderImage(left_, solids, 2 * noise + 1),
      .right = RenderImage(right_, solids, 2 * noise + 2),
      .tof = sr4000_.Measure(scenes::RenderTof(tof_, solids, rig_.left.fx), noise).tof};
  cv::Mat1f& depth_m = images.tof.depth_m;
  for (int i = 0; i < static_cast<int>(depth_m.total()); ++i) {
    const double range_m = depth_m(i) * range_per_depth_(i);
    const double measured_m = (range_m - rig_.range_offset_m) / rig_.range_scale;
    depth_m(i) = static_cast<float>(measured_m / range_per_depth_(i));
  }
  return images;
}

cv::Mat1f RigScene::Truth(int64_t step, const Rectifier& rectifier) const {
  const std::vector<scenes::Solid> solids = scene_.At(step);
  const RectifiedPair& pair = rectifier.rig().pair;
  // The turn of the left camera is part of what became of the ToF camera's pose.
  const Eigen::Matrix3d turn = (rectifier.rig().tof.left_from_tof_rotation *
                                rectifier.raw().left_from_tof.rotation.conjugate())
                                   .toRotationMatrix();
  const Eigen::Vector3d right_m = rig_.left_from_right.translation_m;
  cv::Mat1f truth(pair.size(), std::numeric_limits<float>::quiet_NaN());
  const auto look = [&](int u, int v) {
    const Eigen::Vector3d ray =
        turn.transpose() *
        Eigen::Vector3d((u - pair.cx) / pair.focal_px, (v - pair.cy) / pair.focal_px, 1);
    const Eigen::Vector2d pixel = PixelOfDirection(rectifier.raw().left, ray.hnormalized());
    const Eigen::Vector3d direction = DirectionOfPixel(rig_.left, pixel).homogeneous();
    const double depth_m = Nearest(solids, {{}, ToVec3(direction)});
    const Eigen::Vector3d point = depth_m * direction;
    const double disparity = pair.DisparityFromDepth((turn * point).z());
    if (!(disparity > 0) || u - disparity < 0) return;
    // Whatever is nearer than the point on the right camera's ray hides it.
    constexpr double kAtThePoint = 1 - 1e-6;
    if (Nearest(solids, {ToVec3(right_m), ToVec3(point - right_m)}) < kAtThePoint) return;
    truth(v, u) = static_cast<float>(disparity);
  };
  cv::parallel_for_({0, truth.rows}, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      for (int u = 0; u < truth.cols; ++u) look(u, v);
    }
  });
  return truth;
}

}  // namespace sprout
