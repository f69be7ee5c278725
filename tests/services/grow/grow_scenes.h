#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "common/config/config.h"
#include "common/core/prior_map.h"
#include "common/core/seed.h"

// Made-up scenes for the tests of growth.
namespace sprout::grow {

/// @param levels  grey levels: with 2 there are many ties, with 256 few.
cv::Mat1b Noise(cv::Size size, uint32_t seed, int levels);

/// The right view of a textured scene with disparity `d` everywhere: right(u − d) = left(u).
cv::Mat1b ShiftedBy(const cv::Mat1b& left, int d);

PriorMap ConstantPrior(cv::Size size, double disparity);

/// Quarters of a pixel, below max_disparity.
std::vector<Seed> RandomSeeds(cv::Size size, int count, int max_disparity, uint32_t seed);

/// EPC in whole pixels with a σ_p of 2 px.
GrowConfig EpcConfig();

/// Fails the test at the first pixel that differs.
void ExpectSame(const DisparityImage& fast, const DisparityImage& slow);

}  // namespace sprout::grow
