#ifndef SPROUT_SERVICES_CALIBRATE_VERTICAL_DISPARITY_H_
#define SPROUT_SERVICES_CALIBRATE_VERTICAL_DISPARITY_H_

#include <limits>
#include <opencv2/core.hpp>
#include <span>

#include "common/core/seed.h"

namespace sprout::calibrate {

/// How far rows of the right image lie off those of the left one: 0 for a pair that is rectified.
struct VerticalDisparity {
  static constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

  /// Median over all windows, px; > 0: things lie lower in the right image. NaN = none was matched.
  float median_px = kUnknown;
  /// Medians in equal cells of the left image, 3 rows of 4, px; NaN where fewer than 10 windows
  /// were matched. A roll of a camera shows as a slope across, a wrong focal length as one down.
  cv::Mat1f cells_px;
  int windows = 0;  ///< that were matched
};

/// Matches windows of 9×9 px with texture around known correspondences up to three rows higher and
/// lower: the best of Pearson's correlation, to a fraction of a row by a parabola.
/// @param left, right  pair, grey, of one size.
/// @param seeds        correspondences, as those of Refiner; up to 4000 of them are taken, evenly.
/// O(seeds), about 3 µs each; no I/O; on OpenCV's threads, with the same result for any number.
VerticalDisparity MeasureVerticalDisparity(const cv::Mat1b& left, const cv::Mat1b& right,
                                           std::span<const Seed> seeds);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_CALIBRATE_VERTICAL_DISPARITY_H_
