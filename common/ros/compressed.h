#pragma once

#include <opencv2/core.hpp>

#include "common/ros/cdr.h"
#include "common/ros/to_ros.h"

namespace sprout {

// Images as ROS's image_transport compresses them, on topics beside those of the images.

/// A camera's picture, 8UC1 or 8UC3 (BGR), for "/compressed": JPEG. Some 5 ms a megapixel in grey,
/// 15 in colours.
RosMessage<RosCompressedImage> ToRosJpeg(const RosPlace& place, const cv::Mat& picture);

/// A depth image for "/compressedDepth": 16UC1 in mm, as RosMillimetres(), as PNG, so without
/// loss. Some 25 ms a megapixel.
RosMessage<RosCompressedImage> ToRosCompressedDepth(const RosPlace& place, const DepthImage& depth);

}  // namespace sprout
