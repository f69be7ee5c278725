#ifndef SPROUT_COMMON_ROS2_FROM_ROS_H_
#define SPROUT_COMMON_ROS2_FROM_ROS_H_

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/core/pose.h"
#include "common/core/result.h"
#include "common/core/rig.h"
#include "common/ros2/cdr.h"

namespace sprout {

// The border guard of what comes from ROS: sizes, steps, encodings and layouts are checked before
// memory is taken, an error names field, value and what is allowed.

/// µs since 1970-01-01 UTC, rounded down; an error when nanosec is no part of a second.
Result<int64_t> FromRosStamp(const RosHeader& header);

/// A camera's picture: mono8, 8UC1, mono16 (its upper 8 bits), bgr8, 8UC3, rgb8, bayer_rggb8,
/// bayer_bggr8, bayer_gbrg8 or bayer_grbg8 (bilinear).
/// @returns 8UC1 or 8UC3 (BGR), with pixels of its own.
Result<cv::Mat> FromRosImage(const RosImage& ros);

/// The same from a JPEG stream. @param size  that it must have.
Result<cv::Mat> FromRosImage(const RosCompressedImage& ros, cv::Size size);

/// A range image: 16UC1 or mono16 (mm, 0 = none) or 32FC1 (m, NaN = none).
/// @returns depth along the optical axis, m; no return: not IsReturn().
Result<cv::Mat1f> FromRosDepth(const RosImage& ros);

/// What a CameraInfo says.
struct RosCamera {
  Lens lens;                                                    ///< K and D
  Eigen::Matrix3d rectification = Eigen::Matrix3d::Identity();  ///< R: camera to rectified frame
  double focal_px = 0;                                          ///< of P, px
  double focal_v_px = 0;                                        ///< of its rows
  double cx = 0;                                                ///< of P, px
  double cy = 0;
  double tx = 0;  ///< P[0, 3] = −f·b of a right camera, px·m
};

/// A camera of 'plumb_bob' or without distortion, calibrated (K[0] > 0), neither binned nor
/// cropped.
Result<RosCamera> FromRosInfo(const RosCameraInfo& ros);

/// The pair that two rectified cameras make: one size, one f, one cy, b = −Tx / f > 0.
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
Result<std::vector<RosPose>> FromRosTransforms(const RosTransforms& ros);

}  // namespace sprout

#endif  // SPROUT_COMMON_ROS2_FROM_ROS_H_
