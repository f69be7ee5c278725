#pragma once

#include <span>
#include <vector>

#include "common/core/seed.h"
#include "services/refine/stereo/point_surface.h"
#include "services/refine/surface/range_noise.h"

namespace sprout::refine {

/// Range points of which the images do not show how far they are off, though the sensor is. Where
/// stereo is surer, it counts instead.
class UnsurePoints {
 public:
  /// @param noise  of the points. What their own standard deviation has beside it is an error that
  ///               neighbours share.
  /// @returns whether that error, or noise of which the mean over neighbours is still large, is
  /// such that stereo may be surer. O(1).
  static bool IsUnsure(const Seed& point, const RangeNoise& noise);

  /// Drops unsure points where an interpolation between the others and stereo's seeds is surer than
  /// they, eq. (M1) of the README.
  /// @returns how many. O(points + cells); nothing is done if no point is unsure.
  int Drop(const CellGrid& grid, const RangeNoise& noise, std::span<const Seed> stereo,
           std::vector<Seed>& points);

 private:
  std::vector<Seed> others_;
  PointSurface surface_;
};

}  // namespace sprout::refine
