#include "common/rig/rectifier.h"

#include <Eigen/Geometry>
#include <cassert>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "common/core/image.h"
#include "common/geometry/lens.h"

namespace sprout {
namespace {

cv::Matx33d CameraMatrix(const Lens& lens) {
  return {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1};
}

cv::Matx33d ToCv(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

Eigen::Matrix3d ToEigen(const cv::Matx33d& m) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.val);
}

cv::Matx33d NewCamera(const RectifiedPair& pair, double cx) {
  return {pair.focal_px, 0, cx, 0, pair.focal_px, pair.cy, 0, 0, 1};
}

cv::Point2d RectifiedPixel(const Lens& lens, const cv::Matx33d& turn, const cv::Matx33d& camera,
                           const cv::Point2d& raw_pixel) {
  const Eigen::Vector2d direction = DirectionOfPixel(lens, {raw_pixel.x, raw_pixel.y});
  const cv::Vec3d p = camera * turn * cv::Vec3d(direction.x(), direction.y(), 1);
  return {p[0] / p[2], p[1] / p[2]};
}

}  // namespace

Rectifier::Rectifier(const RawRig& raw) : raw_(raw) {
  assert(CheckRawRig(raw));
  // OpenCV wants the left camera in the right one's frame.
  const Eigen::Matrix3d right_from_left =
      raw.left_from_right.rotation.toRotationMatrix().transpose();
  const Eigen::Vector3d translation = -right_from_left * raw.left_from_right.translation_m;
  const cv::Vec3d t(translation.x(), translation.y(), translation.z());
  cv::Matx34d left_projection;
  cv::Matx34d right_projection;
  cv::Matx44d ignored;
  // alpha = 0: zoomed such that all pixels are seen by the camera.
  cv::stereoRectify(CameraMatrix(raw.left), raw.left.distortion, CameraMatrix(raw.right),
                    raw.right.distortion, raw.left.size(), ToCv(right_from_left), t, left_turn_,
                    right_turn_, left_projection, right_projection, ignored,
                    cv::CALIB_ZERO_DISPARITY, /*alpha=*/0, raw.left.size());
  rig_.pair = {.width = raw.left.width,
               .height = raw.left.height,
               .focal_px = left_projection(0, 0),
               .cx = left_projection(0, 2),
               .cy = left_projection(1, 2),
               .cx_right = right_projection(0, 2),
               .baseline_m = raw.left_from_right.translation_m.norm()};
  left_ = RemapOf(raw.left, left_turn_, rig_.pair.cx);
  right_ = RemapOf(raw.right, right_turn_, rig_.pair.cx_right);
  if (raw.tof.width == 0) return;
  const Eigen::Matrix3d turn = ToEigen(left_turn_);
  rig_.tof = {.width = raw.tof.width,
              .height = raw.tof.height,
              .fx = raw.tof.fx,
              .fy = raw.tof.fy,
              .cx = raw.tof.cx,
              .cy = raw.tof.cy,
              .distortion = raw.tof.distortion};
  rig_.tof.left_from_tof_rotation =
      Eigen::Quaterniond(turn * raw.left_from_tof.rotation.toRotationMatrix()).normalized();
  rig_.tof.left_from_tof_translation_m = turn * raw.left_from_tof.translation_m;
  range_per_depth_ = RangePerDepth(raw.tof);
}

// cv::initUndistortRectifyMap() rounds differently from CPU to CPU.
BilinearRemap Rectifier::RemapOf(const Lens& lens, const cv::Matx33d& turn, double cx) const {
  cv::Mat2f map(rig_.pair.size());
  const Eigen::Matrix3d back = ToEigen(turn.t());
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      const Eigen::Vector3d ray =
          back * Eigen::Vector3d((u - cx) / rig_.pair.focal_px,
                                 (v - rig_.pair.cy) / rig_.pair.focal_px, 1);
      const Eigen::Vector2d pixel = PixelOfDirection(lens, ray.hnormalized());
      map(v, u) = {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
    }
  }
  return {map, lens.size()};
}

void Rectifier::CorrectRanges(TofImage& tof) const {
  if (tof.depth_m.empty() || (raw_.range_scale == 1 && raw_.range_offset_m == 0)) return;
  assert(tof.depth_m.size() == range_per_depth_.size());
  cv::Mat1f corrected = tof.depth_m.clone();  // the image may be shared
  for (int v = 0; v < corrected.rows; ++v) {
    for (int u = 0; u < corrected.cols; ++u) {
      float& depth_m = corrected(v, u);
      if (!IsReturn(depth_m)) continue;
      depth_m = static_cast<float>(raw_.range_scale * depth_m +
                                   raw_.range_offset_m / range_per_depth_(v, u));
    }
  }
  tof.depth_m = corrected;
}

cv::Point2d Rectifier::LeftPixel(const cv::Point2d& raw_pixel) const {
  return RectifiedPixel(raw_.left, left_turn_, NewCamera(rig_.pair, rig_.pair.cx), raw_pixel);
}

cv::Point2d Rectifier::RightPixel(const cv::Point2d& raw_pixel) const {
  return RectifiedPixel(raw_.right, right_turn_, NewCamera(rig_.pair, rig_.pair.cx_right),
                        raw_pixel);
}

}  // namespace sprout
