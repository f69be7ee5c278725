#ifndef SPROUT_SERVICES_GROW_HARRIS_SEEDS_H_
#define SPROUT_SERVICES_GROW_HARRIS_SEEDS_H_

#include <opencv2/core.hpp>
#include <vector>

#include "common/config/config.h"
#include "common/core/seed.h"

namespace sprout::grow {

/// Seeds without a ToF camera, the paper's comparison: Harris corners of both images, matched
/// along rows by MNCC, eq. (1). A match is kept when each corner is the other's best and their
/// MNCC is at least config.min_mncc(). Corners may differ by one row, which the detector's
/// rounding does; the window of the right one is taken at the left one's row.
///
/// @param left, right  rectified pair, grey, of one size, at least 5×5.
/// @returns seeds at whole pixels, strongest left corner first.
/// @throws ConfigError when a value is out of range.
std::vector<Seed> MatchHarrisCorners(const cv::Mat1b& left, const cv::Mat1b& right,
                                     const HarrisConfig& config);

}  // namespace sprout::grow

#endif  // SPROUT_SERVICES_GROW_HARRIS_SEEDS_H_
