#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/core/disparity_image.h"
#include "common/core/result.h"

namespace sprout {

/// The bytes of an image or a map, row by row, without gaps: what raw encodings send. O(pixels).
std::vector<uint8_t> BytesOf(const cv::Mat& image);

/// The other encoding of disparities in lcmtypes/disparity_image_t.lcm and prior_t.lcm. Lossless;
/// O(pixels).
std::vector<uint8_t> EncodeDeltaZstd(const DisparityImage& disparity);

/// The inverse of the raw one and of this; an error when `data` is not exactly one map of `size`.
Result<DisparityImage> DecodeRawInt16(std::span<const uint8_t> data, cv::Size size);
Result<DisparityImage> DecodeDeltaZstd(std::span<const uint8_t> data, cv::Size size);

}  // namespace sprout
