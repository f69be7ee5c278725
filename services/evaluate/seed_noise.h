#ifndef SPROUT_SERVICES_EVALUATE_SEED_NOISE_H_
#define SPROUT_SERVICES_EVALUATE_SEED_NOISE_H_

#include <cstdint>
#include <vector>

#include "common/core/seed.h"

namespace sprout::evaluate {

/// How seeds are damaged, to see what a method makes of a bad ToF camera. It happens after
/// refinement: it stands for what refinement cannot see.
struct SeedNoise {
  double disparity_px = 0;  ///< standard deviation of Gaussian noise on the disparity, px; the
                            ///< seeds say so
  double jitter_px = 0;     ///< the position moves uniformly by up to this in u and in v, px
  uint64_t seed = 1;        ///< of the random numbers
};

/// Damaged copies of the seeds, in the same order: position and disparity are disturbed
/// independently of each other, so that a jittered seed keeps its disparity at a wrong place.
/// Depends on its arguments only, and takes as many random numbers for each seed whatever the
/// amounts: more of the one noise leaves the other as it was. Seeds may leave the image. O(n).
std::vector<Seed> Damage(std::vector<Seed> seeds, const SeedNoise& noise);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_EVALUATE_SEED_NOISE_H_
