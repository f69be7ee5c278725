#ifndef SPROUT_SERVICES_REFINE_SURFACE_WINDOW_DIFFERENCE_H_
#define SPROUT_SERVICES_REFINE_SURFACE_WINDOW_DIFFERENCE_H_

#include <opencv2/core.hpp>

namespace sprout::refine {

/// How much the 5×5 windows around two corresponding pixels differ: the sum of squared differences
/// over the sum of squares, 0 (equal) to 1. The right column may be one pixel off either way, since
/// a ToF point is not more exact: the best of the three counts.
///
/// @param left, right  rectified pair, grey, of one size.
/// @param u, v, u_right  position, px; rounded to whole pixels.
/// @returns infinity when the window leaves the left image, or the right one in all three places.
double WindowDifference(const cv::Mat1b& left, const cv::Mat1b& right, double u, double v,
                        double u_right);

}  // namespace sprout::refine

#endif  // SPROUT_SERVICES_REFINE_SURFACE_WINDOW_DIFFERENCE_H_
