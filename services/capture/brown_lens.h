#ifndef SPROUT_SERVICES_CAPTURE_BROWN_LENS_H_
#define SPROUT_SERVICES_CAPTURE_BROWN_LENS_H_

#include <Eigen/Core>

#include "common/core/rig.h"

namespace sprout {

/// Pixel at which a ToF camera sees a direction (x, y, 1): Brown's distortion, then the intrinsics.
/// Beyond the edge of a strongly distorting lens the result is meaningless.
Eigen::Vector2d PixelOfDirection(const TofCamera& camera, const Eigen::Vector2d& direction);

/// Direction (x, y, 1) that a ToF camera's pixel looks into: the inverse of PixelOfDirection(), to
/// 1e-9 px for a mild lens. Only additions, multiplications and divisions: the same bytes
/// everywhere, which a simulated frame has to have.
Eigen::Vector2d DirectionOfPixel(const TofCamera& camera, const Eigen::Vector2d& pixel);

}  // namespace sprout

#endif  // SPROUT_SERVICES_CAPTURE_BROWN_LENS_H_
