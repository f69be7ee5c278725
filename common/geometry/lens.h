#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>

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

/// Brown's lens in the place of one of another model of OpenCV's.
struct LensFit {
  Lens lens;
  double worst_px = 0;  ///< most by which places over the image differ; 0: it was Brown's
};

/// @param lens        size and intrinsics; its own distortion does not count.
/// @param distortion  OpenCV's k1, k2, p1, p2, k3, k4, …, or k1 to k4 of its fisheye model
///                    (equidistant).
/// @returns the coefficients as they are, where those beyond Brown's five are 0; else the five that
///          fit best over the image (linear least squares); infinite worst_px: none do.
LensFit FitBrown(const Lens& lens, std::span<const double> distortion, bool is_fisheye);

}  // namespace sprout
