#pragma once

#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <string>

#include "common/core/disparity_image.h"
#include "common/core/rig.h"
#include "common/core/seed.h"

namespace sprout {

/// The least disparity that a stage may send, px: that of a point at infinity, which is below 0
/// where the right principal point lies further right than the left one, less a pixel of rounding.
double LeastDisparity(const RectifiedPair& pair);

/// The first disparity below `least_px`, or not below the map's width, and what is allowed:
/// "disparity -3 px at (0, 0); allowed is -1 to 127, or no disparity". Nothing when all are right.
/// O(pixels).
std::optional<std::string> WrongDisparity(const DisparityImage& map, double least_px);

/// The same of seeds that both cameras see: they lie in both images, up to half a pixel outside the
/// outermost pixel centres.
/// @param size  of the images.
/// O(n).
std::optional<std::string> WrongSeed(std::span<const Seed> seeds, cv::Size size, double least_px);

}  // namespace sprout
