#pragma once

#include <limits>
#include <opencv2/core.hpp>

namespace sprout {

/// What a count of 16 bits mostly is.
inline constexpr double kMetresPerMillimetre = 0.001;

/// Depths (m) of a range image whose pixels are counts of 16 bits, wherever it comes from: NaN
/// where there is no return, which is 0 or 65535. For depths in m see IsReturn() (tof_image.h).
/// O(pixels).
/// @param metres_per_count  finite, > 0.
inline cv::Mat1f DepthOfCounts(const cv::Mat1w& counts, double metres_per_count) {
  cv::Mat1f depth_m;
  counts.convertTo(depth_m, CV_32F, metres_per_count);
  depth_m.setTo(std::numeric_limits<float>::quiet_NaN(), (counts == 0) | (counts == 65535));
  return depth_m;
}

}  // namespace sprout
