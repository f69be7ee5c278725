#pragma once

#include <opencv2/core/types.hpp>
#include <span>

#include "common/core/seed.h"

namespace sprout {

/// Unknown coverage: there was no frame yet, or the stage sees no seeds.
inline constexpr float kUnknownCoverage = -1;

/// Share (0 to 1) of the left image that ToF seeds cover: the image is cut into equal cells, about
/// square, with sides of at least width / 40 px and at least 8 px; those with at least one seed of
/// origin ToF count. Seeds outside the image and stereo seeds do not.
///
/// Why these cells: an SR4000 (176 × 144 pixels) that sees the whole image has four columns and
/// rows in each. A lidar of 64 beams has six rows in KITTI's images, and one or two with every
/// fourth beam. So a surface counts as covered although some of its points were dropped, and a hole
/// counts from a fortieth of the image's width on. Below 8 px a cell of a small image could be
/// smaller than the spacing of the seeds.
/// @param size  of the left image, not empty.
/// O(n).
float TofCoverage(std::span<const Seed> seeds, cv::Size size);

}  // namespace sprout
