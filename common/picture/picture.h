#ifndef SPROUT_COMMON_PICTURE_PICTURE_H_
#define SPROUT_COMMON_PICTURE_PICTURE_H_

#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "common/core/disparity_image.h"
#include "common/core/prior_map.h"
#include "common/core/seed.h"
#include "common/core/tof_image.h"
#include "common/picture/color_map.h"

namespace sprout {

// Pictures for people: BGR, on white, with a title above the image and, where colours stand for
// numbers, a labelled colour scale to its right. Text grows with the image and is legible from
// 300 × 200 px on. Titles are ASCII and are written smaller when they are wider than the image.
// All images must not be empty. O(pixels) each.

/// A camera image (8UC1 grey or 8UC3 BGR), without a scale.
cv::Mat3b CameraPicture(const cv::Mat& image, const std::string& title);

/// A disparity map; pixels without a disparity have kNoValueColor.
cv::Mat3b DisparityPicture(const DisparityImage& disparity, const ValueRange& range_px,
                           const std::string& title);

/// The standard deviations of a prior, from 0 to 4 px, so that the pictures of all frames can be
/// compared; what is above looks like 4 px. Pixels without a disparity have kNoValueColor.
cv::Mat3b SigmaPicture(const PriorMap& prior, const std::string& title);

/// The depth of a ToF image; pixels without a return have kNoValueColor. Each ToF pixel becomes a
/// square of the whole number of pixels (at least 1) that brings the area of the picture closest to
/// that of the camera's images, `camera_size`. Without a ToF camera (0×0) nothing has a return.
cv::Mat3b DepthPicture(const TofImage& tof, cv::Size camera_size, const ValueRange& range_m,
                       const std::string& title);

/// Seeds as dots, coloured by disparity, on the darkened left image (8UC1 grey or 8UC3 BGR). Few
/// seeds get large dots, many get small ones. Seeds outside the image are left out.
cv::Mat3b SeedPicture(const cv::Mat& left, std::span<const Seed> seeds, const ValueRange& range_px,
                      const std::string& title);

}  // namespace sprout

#endif  // SPROUT_COMMON_PICTURE_PICTURE_H_
