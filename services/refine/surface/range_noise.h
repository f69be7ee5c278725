#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/geometry/projection.h"

namespace sprout::refine {

/// How far the disparity of a range point is from the mean of its neighbours on either side, along
/// its row or its column, whichever is more: e of eq. (N1) of the README.
struct Deviation {
  float disparity_px;  ///< of the point
  float off_px;        ///< e, ≥ 0
  size_t block = 0;    ///< of NoiseOfBlocks()
};

/// Standard deviation of range points as a function of their disparity, eq. (N1) of the README:
/// σ(d) = s Dᵏ with D = d − d(infinity). In metres the noise grows with z² (k = 0: a ToF camera,
/// which gets less light from afar), with z (k = 1), or is the same everywhere (k = 2: a lidar).
struct RangeNoise {
  double scale = 0;        ///< s
  int power = 0;           ///< k: 0 to 2
  double infinity_px = 0;  ///< disparity of what is infinitely far
  double middle_px = 0;    ///< σ at the median of the disparities, px

  /// σ at a disparity, px: kMinSigmaPx to kMaxSigmaPx of SurfaceRules; below D = 1 px as there.
  double PxAt(double disparity_px) const;
};

/// The noise that the deviations show: with k such that s differs least between near and far. Of no
/// deviation 0. O(deviations), and 3000 of them are sorted.
RangeNoise FindRangeNoise(const std::vector<Deviation>& deviations, double infinity_px);

/// The noise that the deviations of each block show, px; 0 where they are few. O(deviations).
std::vector<double> NoiseOfBlocks(const std::vector<Deviation>& deviations, size_t blocks);

/// Standard deviation of the points' disparities, px, from how far off them the images match best,
/// eq. (N2) of the README. FindRangeNoise() takes the shape of what lies between points that are
/// far apart for noise, too; this does not. But a match errs as well, so noise below 0.5 px is not
/// seen.
///
/// @param left, right  rectified pair, grey, of one size.
/// @returns infinity where no point has its windows in both images.
/// O(1): looks at about 1000 points. No I/O.
double ImageNoisePx(const cv::Mat1b& left, const cv::Mat1b& right,
                    std::span<const ProjectedPoint> points);

}  // namespace sprout::refine
