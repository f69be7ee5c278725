#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "common/core/depth_image.h"
#include "common/core/disparity_image.h"
#include "common/core/rig.h"
#include "common/core/stage_status.h"
#include "common/ros/cdr.h"

namespace sprout {

/// What ROS calls the frames of a rig: optical ones by REP 103 (x right, y down, z forward), as
/// Sprout's own are.
struct RosFrames {
  std::string left = "sprout_left_optical_frame";    ///< of the rectified left camera
  std::string right = "sprout_right_optical_frame";  ///< of the rectified right camera
  std::string tof = "sprout_tof_optical_frame";
};

/// When, and where: the header of a message.
struct RosPlace {
  int64_t utime = 0;  ///< of the capture, µs since 1970-01-01 UTC
  std::string frame;  ///< frame_id
};

/// A time of ours as ROS has it; the years 1902 to 2038.
RosTime RosStamp(int64_t utime);

/// An image as it is: 8UC1 as mono8, 8UC3 as bgr8, 16UC1 as 16UC1, 32FC1 as 32FC1. Borrows its
/// pixels. @pre its rows follow each other without a gap.
RosMessage<RosImage> ToRosImage(const RosPlace& place, const cv::Mat& image);

/// A depth image in mm, 0 where there is no depth, or one beyond 65535 mm.
cv::Mat1w RosMillimetres(const DepthImage& depth);

/// How a depth image is sent (REP 118).
enum class RosDepth {
  kMillimetres,  ///< 16UC1, as RosMillimetres(); borrowed when its counts are millimetres
  kMetres,       ///< 32FC1, NaN where there is none
};
RosMessage<RosImage> ToRosDepth(const RosPlace& place, const DepthImage& depth, RosDepth encoding);

/// Standard deviations of depths: 32FC1, m; NaN where there is no depth, infinite where they have
/// the largest count.
RosMessage<RosImage> ToRosDepthSigma(const RosPlace& place, const DepthImage& sigma);

/// A camera of the rectified pair. P of the right one has −f·b as Tx, so P · (x, y, z, 1) is the
/// pixel of a point of the left frame in either. No distortion; K = P, R = 1.
RosMessage<RosCameraInfo> ToRosLeftInfo(const RosPlace& place, const RectifiedPair& pair);
RosMessage<RosCameraInfo> ToRosRightInfo(const RosPlace& place, const RectifiedPair& pair);
/// The camera of a depth image.
RosMessage<RosCameraInfo> ToRosDepthInfo(const RosPlace& place, const DepthImage& depth);
/// The ToF camera: plumb_bob with its five coefficients.
RosMessage<RosCameraInfo> ToRosTofInfo(const RosPlace& place, const TofCamera& tof);

/// Points in one row: x, y, z (FLOAT32, m), rgb (FLOAT32 that holds 0x00rrggbb, as RViz and PCL
/// have it) and confidence (UINT8), 20 bytes each.
RosMessage<RosPointCloud> ToRosCloud(const RosPlace& place, const PointCloud& cloud);

/// The same points at their places in an image (an ordered cloud): one for every `stride`-th pixel
/// of every `stride`-th row of the left image, NaN where there is none. An error when a point is at
/// none of these pixels.
Result<RosMessage<RosPointCloud>> ToRosOrderedCloud(const RosPlace& place, const PointCloud& cloud,
                                                    const RectifiedPair& pair, int stride);

/// Disparities as stereo_msgs wants them, z = f·t / d: adjusted by the principal points, d = u − u'
/// − (cx − cx'). Where there is none, min_disparity − 1. O(pixels).
RosMessage<RosDisparity> ToRosDisparity(const RosPlace& place, const DisparityImage& disparity,
                                        const RectifiedPair& pair);

/// Where the right and the ToF camera stand in the left one's frame.
RosMessage<RosTransforms> ToRosTransforms(int64_t utime, const Rig& rig, const RosFrames& frames);

/// How a process fares.
struct RosHealth {
  StageStatus status;
  double silent_s = 0;  ///< how long it has been silent though it should be heard, s; 0: it is not
};

/// How processes fare, one entry each, named "sprout: STAGE". ERROR: it stopped; STALE: it is
/// silent; WARN: something went wrong, and the message says what. The numbers are in the values.
RosMessage<RosDiagnostics> ToRosDiagnostics(int64_t utime,
                                            const std::map<std::string, RosHealth>& processes);

}  // namespace sprout
