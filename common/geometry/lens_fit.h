#ifndef SPROUT_COMMON_GEOMETRY_LENS_FIT_H_
#define SPROUT_COMMON_GEOMETRY_LENS_FIT_H_

#include <span>

#include "common/core/rig.h"

namespace sprout {

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

#endif  // SPROUT_COMMON_GEOMETRY_LENS_FIT_H_
