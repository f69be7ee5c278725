#pragma once

#include <opencv2/core.hpp>

#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/core/tof_image.h"
#include "common/rig/bilinear_remap.h"
#include "common/rig/raw_rig.h"
#include "common/rig/rectification.h"

namespace sprout {

/// Rectifies a rig's images and removes the bias of its ranges. Both cameras are rotated to one
/// direction, perpendicular to the baseline (RectificationOf()), with a common focal length that
/// leaves no empty border; at the edge a pixel may be repeated. The images keep their size.
/// Thread-compatible; copies share the maps.
class Rectifier {
 public:
  /// O(pixels): makes both maps, 3.5 bytes a pixel each.
  /// @pre CheckRawRig(rig).
  explicit Rectifier(const RawRig& rig);

  /// The rig after rectification: what goes on SPROUT_RIG.
  const Rig& rig() const { return rig_; }
  const RawRig& raw() const { return raw_; }
  const RectifiedViews& views() const { return views_; }

  /// An image of the left or right camera, rectified: bilinear, in fixed point, so the same bytes
  /// everywhere. O(pixels).
  /// @param image  8UC1 or 8UC3, of the calibrated size.
  cv::Mat RectifyLeft(const cv::Mat& image) const { return left_.Apply(image); }
  cv::Mat RectifyRight(const cv::Mat& image) const { return right_.Apply(image); }

  /// Rectifies both images of a capture and corrects its ranges, in place.
  /// @param tof  0×0: there is none.
  /// @returns an error that names the first of the three that has another size than the calibrated
  ///          one; then all stay as they are.
  Result<void> Rectify(cv::Mat& left, cv::Mat& right, TofImage& tof) const;

  /// Depths without the bias of the range; pixels without a return stay as they are.
  /// @param tof  of the calibrated size, or 0×0.
  void CorrectRanges(TofImage& tof) const;

  /// Position in the rectified left or right image of a pixel of the unrectified one.
  cv::Point2d LeftPixel(const cv::Point2d& raw_pixel) const;
  cv::Point2d RightPixel(const cv::Point2d& raw_pixel) const;

 private:
  BilinearRemap RemapOf(const Lens& lens, const cv::Matx33d& turn, double cx) const;

  RawRig raw_;
  Rig rig_;
  RectifiedViews views_;
  cv::Matx33d left_turn_;  // from the camera's frame to the rectified one
  cv::Matx33d right_turn_;
  BilinearRemap left_;
  BilinearRemap right_;
  cv::Mat1d range_per_depth_;  // of the ToF camera
};

}  // namespace sprout
