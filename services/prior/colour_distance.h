#ifndef SPROUT_SERVICES_PRIOR_COLOUR_DISTANCE_H_
#define SPROUT_SERVICES_PRIOR_COLOUR_DISTANCE_H_

#include <cstdlib>
#include <opencv2/core.hpp>

namespace sprout {

/// Sum of the differences in blue, green and red: 0 to 765.
inline int ColourDistance(const cv::Vec3b& a, const cv::Vec3b& b) {
  return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
}

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_COLOUR_DISTANCE_H_
