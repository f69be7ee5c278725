#ifndef SPROUT_COMMON_GEOMETRY_LENS_H_
#define SPROUT_COMMON_GEOMETRY_LENS_H_

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "common/core/rig.h"

namespace sprout {

/// Pixel at which a camera sees a direction (x, y, 1): Brown's distortion, then the intrinsics.
/// Outside the image of a strongly distorting lens the result is meaningless.
Eigen::Vector2d PixelOfDirection(const Lens& lens, const Eigen::Vector2d& direction);

/// Viewing direction (x, y, 1) of a camera's pixel: the inverse of PixelOfDirection(), to
/// 1e-9 px for a mild lens. Only additions, multiplications and divisions: the same bytes
/// everywhere, as simulated frames need.
Eigen::Vector2d DirectionOfPixel(const Lens& lens, const Eigen::Vector2d& pixel);

/// Range along the ray for a depth of 1, for every pixel: the length of (x, y, 1). O(pixels).
cv::Mat1d RangePerDepth(const Lens& lens);

}  // namespace sprout

#endif  // SPROUT_COMMON_GEOMETRY_LENS_H_
