#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "common/core/seed.h"

namespace sprout::evaluate {

/// Settings of MatchHarrisCorners().
struct HarrisSettings {
  int max_corners = 20000;                ///< in each image
  double min_relative_response = 0.0001;  ///< smallest response, as share of the strongest corner's
  double min_mncc = 0.8;                  ///< smallest MNCC of a match, −1 to 1
  int max_disparity_px = 0;               ///< largest one searched, px; 0 = a quarter of the width
};

/// Seeds without a ToF camera, the paper's comparison: Harris corners of both images, matched
/// along rows by MNCC, eq. (1). A match is kept when each corner is the other's best and their
/// MNCC is at least settings.min_mncc. Corners may differ by one row, because the detector rounds;
/// the window of the right one is taken at the left one's row.
///
/// @param left, right  rectified pair, grey, of one size, at least 5×5.
/// @returns seeds at whole pixels, strongest left corner first.
std::vector<Seed> MatchHarrisCorners(const cv::Mat1b& left, const cv::Mat1b& right,
                                     const HarrisSettings& settings);

}  // namespace sprout::evaluate
