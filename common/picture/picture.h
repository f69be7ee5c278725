#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "common/core/disparity_image.h"
#include "common/core/prior_map.h"
#include "common/core/rig.h"
#include "common/core/seed.h"
#include "common/core/tof_image.h"
#include "common/picture/color_map.h"
#include "common/picture/color_scale.h"

namespace sprout {

// Pictures for people: BGR, on white, with a title above the image and, if colours stand for
// numbers, a labelled colour scale to its right. Near is red and far is blue in all of them; a
// scale has numbers at every size, and an arrow at an end with values beyond it. Text grows with
// the image and is always legible: the white paper extends beyond the image if necessary. Titles
// are ASCII; those wider than the image are written smaller, but still legible. All images must not
// be empty. O(pixels) each.

/// A camera image (8UC1 grey or 8UC3 BGR), without a scale.
cv::Mat3b CameraPicture(const cv::Mat& image, const std::string& title);

/// Any picture with a scale beside it.
cv::Mat3b ScaledPicture(const cv::Mat3b& image, const std::string& title,
                        const ScaleContent& content);

/// The scale of disparities; with the pair (may be null) also in metres.
ScaleContent DisparityScale(const ValueRange& range_px, const RectifiedPair* pair);

/// A disparity map; pixels without a disparity have kNoValueColor.
/// @param pair  if known, the scale also has depths in metres.
cv::Mat3b DisparityPicture(const DisparityImage& disparity, const ValueRange& range_px,
                           const std::string& title, const RectifiedPair* pair = nullptr);

/// The standard deviations of a prior, or of another map, from 0 to 4 px, so that the pictures of
/// all frames can be compared; larger ones look like 4 px. Pixels without a disparity have
/// kNoValueColor.
cv::Mat3b SigmaPicture(const PriorMap& prior, const std::string& title);

/// A confidence (8UC1) as the probability that it stands for, from 0, black, to 1, white.
cv::Mat3b ConfidencePicture(const cv::Mat1b& confidence, const std::string& title);

/// Errors of a disparity map, from 0 (blue) to kLargestErrorPx (red); pixels with NaN, which are
/// not scored, have kNoValueColor; those with an infinite error, which have no disparity, have the
/// colour of the largest error.
cv::Mat3b ErrorPicture(const cv::Mat1f& error_px, const std::string& title);

/// The colours of the errors alone, without margin, title and scale.
cv::Mat3b ColorizeErrors(const cv::Mat1f& error_px);

inline constexpr double kLargestErrorPx = 4;

/// The depth of a ToF image; pixels without a return have kNoValueColor. Each ToF pixel becomes a
/// square whose side is a whole number of pixels (at least 1), chosen such that the area of the
/// picture is closest to that of the camera's images, `camera_size`. Without a ToF camera (0×0) no
/// pixel has a return.
/// @param range_m  0 < min < max: the DepthRange() of the disparity pictures' range, for the same
///                 colours as there.
cv::Mat3b DepthPicture(const TofImage& tof, cv::Size camera_size, const ValueRange& range_m,
                       const std::string& title);

/// Seeds as dots, coloured by disparity, on the darkened left image (8UC1 grey or 8UC3 BGR). Few
/// seeds get large dots, many get small ones. Seeds outside the image are left out.
/// @param pair  as for DisparityPicture().
cv::Mat3b SeedPicture(const cv::Mat& left, std::span<const Seed> seeds, const ValueRange& range_px,
                      const std::string& title, const RectifiedPair* pair = nullptr);

}  // namespace sprout
