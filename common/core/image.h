#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include "common/core/result.h"

namespace sprout {

/// Largest width and height of any image or map, px, and most pixels: as a map of 2 bytes a pixel
/// it then fits into a message.
inline constexpr int kMaxSide = 16384;
inline constexpr int64_t kMaxPixels = 100'000'000;

/// Grey values of an 8-bit grey or BGR image (a grey one is shared, not copied). O(pixels).
cv::Mat1b ToGrey(const cv::Mat& image);

/// ToGrey() that reuses the memory of the caller.
cv::Mat1b ToGrey(const cv::Mat& image, cv::Mat1b& memory);

/// Colours (BGR) of an 8-bit grey or BGR image (a BGR one is shared, not copied). O(pixels).
cv::Mat3b ToBgr(const cv::Mat& image);

/// ToBgr() that reuses the memory of the caller.
cv::Mat3b ToBgr(const cv::Mat& image, cv::Mat3b& memory);

/// The mean of every 2×2 pixels; in an image of odd width or height the last column or row is
/// repeated.
cv::Mat1b Halved(const cv::Mat1b& image);

/// "640x480", for messages to people.
std::string SizeText(cv::Size size);

/// @returns an error when an image has another size than the calibrated one: "left image of 64x48:
///          allowed is the calibrated size 640x480", of `what` "left image".
/// @param calibrated  0×0: the calibration has no such camera.
Result<void> CheckImageSize(const std::string& what, cv::Size size, cv::Size calibrated);

}  // namespace sprout
