#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "common/geometry/projection.h"

namespace sprout::refine {

/// Standard deviation of the points' disparities, px, by how far beside them the images match best.
/// In contrast to TofSurface::Noise() it does not take the shape of what lies between points that
/// are far apart for noise; but a match errs as well, so noise below 0.5 px is not seen.
///
/// @param left, right  rectified pair, grey, of one size.
/// @returns infinity where no point has its windows in both images.
/// O(1): looks at about 1000 points. No I/O.
double ImageNoisePx(const cv::Mat1b& left, const cv::Mat1b& right,
                    std::span<const ProjectedPoint> points);

}  // namespace sprout::refine
