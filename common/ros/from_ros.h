#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/pose.h"
#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/ros/cdr.h"

namespace sprout {

// The border guard of what comes from ROS: sizes, steps, encodings and layouts are checked before
// memory is taken, an error names field, value and what is allowed.

/// µs since 1970-01-01 UTC, rounded down; an error when nanosec is no part of a second.
Result<int64_t> FromRosStamp(const RosHeader& header);

/// A camera's picture: mono8, 8UC1, mono16, 16UC1, bgr8, 8UC3, rgb8, bgra8, rgba8,
/// yuv422 or uyvy (U Y V Y), yuv422_yuy2 or yuyv (Y U Y V), or the Bayer patterns bayer_rggb8,
/// bayer_bggr8, bayer_gbrg8, bayer_grbg8 and the same with 16 (bilinear).
/// @returns grey or BGR of 8 bits, or of 16 (see EightBits), with pixels of its own.
Result<cv::Mat> FromRosImage(const RosImage& ros);

/// The same from a PNG or JPEG stream, which is known by its first bytes, not by `format`: that is
/// read for a Bayer pattern only.
/// @param size  that it must have; nothing: any.
Result<cv::Mat> FromRosImage(const RosCompressedImage& ros, std::optional<cv::Size> size);

/// A range image: 16UC1 or mono16 (mm; 0 and 65535: none) or 32FC1 (m, NaN: none).
/// @returns depth along the optical axis, m; no return: not IsReturn().
Result<cv::Mat1f> FromRosDepth(const RosImage& ros);

/// The same from what image_transport's compressedDepth sends: 12 bytes of parameters and a PNG of
/// 16 bits, which holds mm or, where `format` begins with 32FC1, quantised inverse depths; or from
/// a PNG of mm alone.
/// @param size  that it must have; nothing: any.
Result<cv::Mat1f> FromRosDepth(const RosCompressedImage& ros, std::optional<cv::Size> size);

/// What a CameraInfo says.
struct RosCamera {
  int width = 0;  ///< px
  int height = 0;
  /// K and D, of rational_polynomial and equidistant the nearest of plumb_bob's (FitBrown()); or
  /// why there is no such lens: not calibrated, another model, or more than 0.5 px from plumb_bob.
  /// Images that are rectified need none, P says all of them.
  Result<Lens> lens;
  Eigen::Matrix3d rectification = Eigen::Matrix3d::Identity();  ///< R: camera to rectified frame
  double focal_px = 0;                                          ///< of P, px
  double focal_v_px = 0;                                        ///< of its rows
  double cx = 0;                                                ///< of P, px
  double cy = 0;
  double tx = 0;  ///< P[0, 3] = −f·x of a camera that stands x to the right of a common one, px·m

  cv::Size size() const { return {width, height}; }

  /// The camera of rectified images: P alone.
  Lens RectifiedLens() const {
    return {width, height, focal_px, focal_v_px, cx, cy, /*distortion=*/{}};
  }
};

/// A camera that has been calibrated, of any lens model; of an image that is binned or a part (roi)
/// of what was calibrated, the camera that sees just this.
/// @param is_rectified  its images are, so P[0] > 0 is required; else `lens` says whether K is
/// usable.
Result<RosCamera> FromRosInfo(const RosCameraInfo& ros, bool is_rectified = true);

/// The pair that two rectified cameras make: one size, one f, one cy, b = (Tx − Tx') / f > 0, so
/// that both may be relative to a third camera. Pixels are square: f_y of P may differ from f_x by
/// what moves no row by more than half a pixel.
Result<RectifiedPair> PairOf(const RosCamera& left, const RosCamera& right);

/// Points of a cloud (m, in its own frame), whatever else a point holds: x, y and z are float32,
/// anywhere in it. Points that are not finite or beyond 1000 m are left out: drivers mark pixels
/// without a return so.
Result<std::vector<Eigen::Vector3d>> FromRosCloud(const RosPointCloud& ros);

/// Where a frame stands in its parent's.
struct RosPose {
  std::string parent;
  std::string child;
  Pose parent_from_child = {};
};

/// An error: its rotation is none, or its translation is not finite.
Result<RosPose> FromRosTransform(const RosTransform& ros);

/// A decoded picture of 8 or 16 bits (grey, BGR, BGRA) as grey or BGR, of as many bits.
/// @param encoding  of the image before it was compressed: of a Bayer pattern, which grey pixels
///                  are, colours are made; others leave the picture as it is.
Result<cv::Mat> ToPicture(const cv::Mat& stored, std::string_view encoding);

}  // namespace sprout
