#ifndef SPROUT_COMMON_GEOMETRY_LENS_H_
#define SPROUT_COMMON_GEOMETRY_LENS_H_

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "common/core/rig.h"

namespace sprout {

/// Pixel at which a camera sees a direction (x, y, 1): Brown's distortion, then the intrinsics.
/// Beyond the edge of a strongly distorting lens the result is meaningless.
Eigen::Vector2d PixelOfDirection(const Lens& lens, const Eigen::Vector2d& direction);

/// Direction (x, y, 1) that a camera's pixel looks into: the inverse of PixelOfDirection(), to
/// 1e-9 px for a mild lens. Only additions, multiplications and divisions: the same bytes
/// everywhere, which a simulated frame has to have.
Eigen::Vector2d DirectionOfPixel(const Lens& lens, const Eigen::Vector2d& pixel);

/// Range along the ray of one unit of depth, for every pixel: the length of (x, y, 1). O(pixels).
cv::Mat1d RangePerDepth(const Lens& lens);

}  // namespace sprout

#endif  // SPROUT_COMMON_GEOMETRY_LENS_H_
