#pragma once

#include <opencv2/core.hpp>

#include "common/inputs/findings.h"

namespace sprout::inputs {

/// Grey levels, standard deviation: less than the noise of a camera that sees something.
inline constexpr double kBlankContrast = 1.5;

/// Answers Question::kBits by each image alone.
/// @param left, right  grey, of one size.
/// O(pixels), 0.1 to 2.4 ms; one thread.
Finding JudgeBits(const cv::Mat1b& left, const cv::Mat1b& right);

}  // namespace sprout::inputs
