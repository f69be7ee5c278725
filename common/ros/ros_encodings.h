#ifndef SPROUT_COMMON_ROS_ROS_ENCODINGS_H_
#define SPROUT_COMMON_ROS_ROS_ENCODINGS_H_

#include <opencv2/core.hpp>
#include <string_view>

#include "common/core/result.h"

namespace sprout {

/// A decoded picture of 8 or 16 bits (grey, BGR, BGRA) as grey or BGR, of as many bits.
/// @param encoding  of the image before it was compressed: of a Bayer pattern, which grey pixels
///                  are, colours are made; others leave the picture as it is.
Result<cv::Mat> ToPicture(const cv::Mat& stored, std::string_view encoding);

}  // namespace sprout

#endif  // SPROUT_COMMON_ROS_ROS_ENCODINGS_H_
