#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/core/disparity_image.h"
#include "common/core/result.h"

namespace sprout {

/// The two encodings of disparities in lcmtypes/disparity_image_t.lcm and prior_t.lcm. Both
/// lossless; O(pixels).
std::vector<uint8_t> EncodeRawInt16(const DisparityImage& disparity);
std::vector<uint8_t> EncodeDeltaZstd(const DisparityImage& disparity);

/// The inverse; an error when `data` is not exactly one map of `size`.
Result<DisparityImage> DecodeRawInt16(std::span<const uint8_t> data, cv::Size size);
Result<DisparityImage> DecodeDeltaZstd(std::span<const uint8_t> data, cv::Size size);

}  // namespace sprout
