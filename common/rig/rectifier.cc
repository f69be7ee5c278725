#include "common/rig/rectifier.h"

#include <cassert>

#include "common/core/image.h"
#include "common/geometry/lens.h"

namespace sprout {

Rectifier::Rectifier(const RawRig& raw) : raw_(raw) {
  assert(CheckRawRig(raw));
  const Rectification made = RectificationOf(raw);
  left_turn_ = made.left_turn;
  right_turn_ = made.right_turn;
  rig_ = RectifiedRig(raw, made);
  views_ = ViewsOf(raw, made);
  left_ = RemapOf(raw.left, left_turn_, rig_.pair.cx);
  right_ = RemapOf(raw.right, right_turn_, rig_.pair.cx_right);
  if (raw.tof.width == 0) return;
  range_per_depth_ = RangePerDepth(raw.tof);
}

// cv::initUndistortRectifyMap() rounds differently from CPU to CPU.
BilinearRemap Rectifier::RemapOf(const Lens& lens, const cv::Matx33d& turn, double cx) const {
  cv::Mat2f map(rig_.pair.size());
  const Eigen::Matrix3d back = BackOf(turn);
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      const Eigen::Vector2d pixel = RawPixel(lens, back, rig_.pair, cx, u, v);
      map(v, u) = {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
    }
  }
  return {map, lens.size()};
}

Result<void> Rectifier::Rectify(cv::Mat& left, cv::Mat& right, TofImage& tof) const {
  Result<void> fits = CheckImageSize("left image", left.size(), raw_.left.size());
  if (fits) fits = CheckImageSize("right image", right.size(), raw_.right.size());
  if (fits && !tof.depth_m.empty()) {
    fits = CheckImageSize("ToF image", tof.depth_m.size(), raw_.tof.size());
  }
  if (!fits) return fits;
  left = RectifyLeft(left);
  right = RectifyRight(right);
  CorrectRanges(tof);
  return {};
}

void Rectifier::CorrectRanges(TofImage& tof) const {
  if (tof.depth_m.empty() || raw_.HasRightRanges()) return;
  assert(tof.depth_m.size() == range_per_depth_.size());
  const bool has_light = tof.amplitude.size() == tof.depth_m.size();
  cv::Mat1f corrected = tof.depth_m.clone();  // the image may be shared
  for (int v = 0; v < corrected.rows; ++v) {
    for (int u = 0; u < corrected.cols; ++u) {
      float& depth_m = corrected(v, u);
      if (!IsReturn(depth_m)) continue;
      const double length = range_per_depth_(v, u);
      double right_m = raw_.range_scale * depth_m + raw_.range_offset_m / length;
      if (!raw_.range_correction.empty()) {
        right_m += CorrectionAt(raw_.range_correction, right_m * length).offset_m / length;
      }
      if (const AmplitudeCorrection& light = raw_.amplitude_correction;
          !light.empty() && has_light) {
        right_m += light.offset_m * BrightnessOf(tof.amplitude(v, u), light.middle) / length;
      }
      depth_m = static_cast<float>(right_m);
    }
  }
  tof.depth_m = corrected;
}

cv::Point2d Rectifier::LeftPixel(const cv::Point2d& raw_pixel) const {
  return RectifiedPixel(raw_.left, left_turn_, rig_.pair, rig_.pair.cx, raw_pixel);
}

cv::Point2d Rectifier::RightPixel(const cv::Point2d& raw_pixel) const {
  return RectifiedPixel(raw_.right, right_turn_, rig_.pair, rig_.pair.cx_right, raw_pixel);
}

}  // namespace sprout
