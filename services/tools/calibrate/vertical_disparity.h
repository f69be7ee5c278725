#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_VERTICAL_DISPARITY_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_VERTICAL_DISPARITY_H_

#include <limits>
#include <opencv2/core.hpp>
#include <span>

#include "common/core/seed.h"

namespace sprout::calibrate {

/// Vertical offset of the right image's rows against the left one's: 0 for a rectified pair.
struct VerticalDisparity {
  static constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

  /// Median over all windows, px; > 0: lower in the right image. NaN = no window was matched.
  float median_px = kUnknown;
  /// Medians in equal cells of the left image, 3 rows of 4, px; NaN where fewer than 10 windows
  /// were matched. A roll of a camera shows as a slope from left to right, a wrong focal length as
  /// one from top to bottom.
  cv::Mat1f cells_px;
  int windows = 0;  ///< number that were matched
};

/// Matches windows of 9×9 px with texture around known correspondences up to three rows higher and
/// lower: the largest Pearson correlation, with sub-row position from a parabola.
/// @param left, right  pair, grey, of one size.
/// @param seeds        correspondences, as those of Refiner; at most 4000 of them are used, evenly
/// chosen.
/// O(seeds), about 3 µs each; no I/O; on OpenCV's threads, with the same result for any number.
VerticalDisparity MeasureVerticalDisparity(const cv::Mat1b& left, const cv::Mat1b& right,
                                           std::span<const Seed> seeds);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_VERTICAL_DISPARITY_H_
