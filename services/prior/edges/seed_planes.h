#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/core/seed.h"
#include "services/prior/triangulation/triangulation.h"

namespace sprout::prior {

/// A plane of disparity over the left image.
struct Plane {
  float u = 0;  ///< position of its reference point, px
  float v = 0;
  float disparity = 0;   ///< there, px
  float per_column = 0;  ///< slope, px of disparity a px
  float per_row = 0;
  float sigma_px = 0;  ///< standard deviation of the disparity there

  /// Disparity at a pixel, px.
  float At(float at_u, float at_v) const {
    return disparity + per_column * (at_u - u) + per_row * (at_v - v);
  }
};

/// A level plane at the seed's own disparity.
inline Plane LevelPlane(const Seed& seed) {
  return {.u = seed.u, .v = seed.v, .disparity = seed.disparity(), .sigma_px = seed.sigma_px};
}

/// Whether a seed's own disparity is so noisy that the plane through its neighbours is better.
/// Always so for seeds from stereo, whose errors are independent.
inline bool IsNoisy(const Seed& seed, const PriorConfig& config) {
  return seed.origin == SeedOrigin::kStereo || seed.sigma_px > config.noisy_px();
}

/// The spacing of the seeds: the median length of the triangles' sides, px; 1 without triangles.
double SpacingPx(std::span<const Seed> seeds, std::span<const SeedTriangle> triangles);

/// The quantisation step of the ToF seeds' disparities, px: the 10 % quantile of the nonzero
/// differences between neighbours on one surface. Small if the disparities are not quantised.
double StepPx(std::span<const Seed> seeds, std::span<const SeedTriangle> triangles,
              double spacing_px, const PriorConfig& config);

/// A plane at each seed, fitted to the seeds around it with an M-estimator: eqs. (P1) to (P3) of
/// the README.
///
/// @param spacing_px  SpacingPx() of the seeds.
/// @param step_px     StepPx() of the seeds.
/// @returns one plane a seed, in their order; of a seed in no triangle, a level one at its
/// disparity.
/// O(seeds); on OpenCV's threads, with the same result for any number.
std::vector<Plane> FitPlanes(std::span<const Seed> seeds, const Triangulation& triangulation,
                             double spacing_px, double step_px, const PriorConfig& config);

/// Continues the seeds' surface beyond their hull: a copy of each seed of the hull on its own
/// plane, moved outwards, and two triangles for each side of the hull between them. So slanted
/// surfaces stay slanted beyond the hull, and depth edges are resolved there as inside it. The
/// standard deviation of a copy grows with the distance to its seed, eq. (P8).
///
/// @param hull      of Triangulation.
/// @param size      of the left image, px: copies do not go beyond it.
/// @param reach_px  how far outwards copies are moved.
/// @param planes    of the seeds; copies are appended.
/// @param triangles of these; those beyond the hull are appended.
/// O(hull).
void ExtendBeyondHull(std::span<const int> hull, cv::Size size, double reach_px,
                      const PriorConfig& config, std::vector<Plane>& planes,
                      std::vector<SeedTriangle>& triangles);

}  // namespace sprout::prior
