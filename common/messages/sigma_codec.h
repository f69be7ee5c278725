#ifndef SPROUT_COMMON_MESSAGES_SIGMA_CODEC_H_
#define SPROUT_COMMON_MESSAGES_SIGMA_CODEC_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/result.h"

namespace sprout {

/// The two encodings of the standard deviations in lcmtypes/prior_t.lcm, counts as in PriorMap.
/// Both lossless; O(pixels).
std::vector<uint8_t> EncodeSigmaRaw(const cv::Mat1b& sigma);
std::vector<uint8_t> EncodeSigmaDeltaZstd(const cv::Mat1b& sigma);

/// The inverse; an error when `data` is not exactly one map of `size`.
Result<cv::Mat1b> DecodeSigmaRaw(std::span<const uint8_t> data, cv::Size size);
Result<cv::Mat1b> DecodeSigmaDeltaZstd(std::span<const uint8_t> data, cv::Size size);

}  // namespace sprout

#endif  // SPROUT_COMMON_MESSAGES_SIGMA_CODEC_H_
