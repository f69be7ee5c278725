#ifndef SPROUT_SERVICES_PRIOR_SEED_SPREADING_H_
#define SPROUT_SERVICES_PRIOR_SEED_SPREADING_H_

#include <opencv2/core.hpp>
#include <span>

#include "common/core/seed.h"

namespace sprout {

/// Spreads the seeds' disparities over the left image with OpenCV's FastGlobalSmoother (Min et al.,
/// "Fast Global Image Smoothing Based on Weighted Least Squares", TIP 2014, IV-B): smoothed
/// disparities over smoothed weights, an average of the seeds that no edge of the image separates
/// from the pixel. Looks at one image only.
///
/// @param seeds   on their nearest pixels; of two on one pixel the later counts, one outside not.
/// @param left    CV_8UC1 or CV_8UC3.
/// @param lambda  strength of the smoothing, > 0.
/// @param sigma   difference of colours over which it hardly goes, grey levels, > 0.
/// @returns disparities, px; NaN where no seed reaches, all NaN without seeds.
/// O(pixels); no I/O; uses OpenCV's threads, with the same result for any number.
cv::Mat1f SpreadSeeds(std::span<const Seed> seeds, const cv::Mat& left, double lambda,
                      double sigma);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_SEED_SPREADING_H_
