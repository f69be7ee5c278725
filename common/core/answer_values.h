#pragma once

#include <opencv2/core/types.hpp>
#include <optional>
#include <span>
#include <string>

#include "common/core/disparity_image.h"
#include "common/core/seed.h"

namespace sprout {

/// The first disparity that no stage may send, and what is allowed: those from 0 to less than the
/// map's width. "disparity -3 px at (0, 0); allowed is 0 to 127, or no disparity". Nothing when all
/// are right. O(pixels).
std::optional<std::string> WrongDisparity(const DisparityImage& map);

/// The same of seeds that both cameras see: they lie in both images, up to half a pixel outside the
/// outermost pixel centres, with u >= u_right.
/// @param size  of the images.
/// O(n).
std::optional<std::string> WrongSeed(std::span<const Seed> seeds, cv::Size size);

}  // namespace sprout
