#ifndef SPROUT_COMMON_SCENES_RECTIFIED_H_
#define SPROUT_COMMON_SCENES_RECTIFIED_H_

#include <cmath>

namespace sprout::scenes {

/// What the two matrices of a rectified pair have in common.
struct RectifiedLens {
  double fx_px;
  double fy_px;
  double cy_px;  ///< row of the principal point
};

/// Whether both cameras have one focal length, the same on both axes, and the same row of the
/// principal point, but for the rounding of numbers that are written as text (0.01 px).
inline bool AreRectified(const RectifiedLens& left, const RectifiedLens& right) {
  constexpr double kRoundingPx = 0.01;
  const auto same = [](double a, double b) { return std::abs(a - b) <= kRoundingPx; };
  return same(left.fx_px, left.fy_px) && same(left.fx_px, right.fx_px) &&
         same(left.fx_px, right.fy_px) && same(left.cy_px, right.cy_px);
}

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_RECTIFIED_H_
