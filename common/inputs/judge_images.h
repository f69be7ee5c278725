#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "common/inputs/findings.h"

namespace sprout::inputs {

/// Grey levels, standard deviation: less than the noise of a camera that sees something.
inline constexpr double kBlankContrast = 1.5;

/// Answers Question::kBits by each image alone.
/// @param left, right  grey, of one size.
/// O(pixels), 0.1 to 2.4 ms; one thread.
Finding JudgeBits(const cv::Mat1b& left, const cv::Mat1b& right);

/// Whether one image is blurred, where too few corners have partners to compare contrasts by: then
/// it has less contrast on fine levels, and the less, the finer they are; other things have the
/// same less on all of them.
/// @returns a bad finding of Question::kContrast; nothing where that does not show. O(pixels).
std::optional<Finding> FindBlur(const cv::Mat1b& left, const cv::Mat1b& right);

}  // namespace sprout::inputs
