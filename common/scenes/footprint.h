#ifndef SPROUT_COMMON_SCENES_FOOTPRINT_H_
#define SPROUT_COMMON_SCENES_FOOTPRINT_H_

#include <vector>

#include "common/scenes/tof_samples.h"

namespace sprout::scenes {

/// What one ToF pixel looks at.
struct Footprint {
  int known = 0;        ///< samples with a surface
  double light = 0;     ///< mean light that comes back, in the unit of albedo / m²
  double mixed_m = 0;   ///< depth of all light together
  double middle_m = 0;  ///< depth of the surface that fills most of the pixel
  double spread = 0;    ///< between the nearest and the farthest depth, a share of the nearest
  int samples = 0;      ///< known or not

  bool IsMostlyKnown() const { return 2 * known >= samples; }
};

/// The footprints of all ToF pixels, row by row.
/// @param footprint_px  side of the square that a pixel gathers light from, ToF px, ≥ 1.
std::vector<Footprint> FootprintsOf(const TofSamples& samples, double footprint_px);

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_FOOTPRINT_H_
