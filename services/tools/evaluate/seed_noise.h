#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_SEED_NOISE_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_SEED_NOISE_H_

#include <cstdint>
#include <vector>

#include "common/core/seed.h"

namespace sprout::evaluate {

/// Noise added to seeds, to test methods with a bad ToF camera. It is added after refinement: it
/// models errors that refinement cannot detect.
struct SeedNoise {
  double disparity_px = 0;  ///< standard deviation of Gaussian noise on the disparity, px; the
                            ///< seeds' sigma_px includes it
  double jitter_px = 0;     ///< the position moves uniformly by up to this in u and in v, px
  uint64_t seed = 1;        ///< of the random numbers
};

/// Noisy copies of the seeds, in the same order. Noise on position and on disparity are
/// independent, so a jittered seed keeps its disparity at a wrong place. The result depends on the
/// arguments only, and the number of random numbers for each seed does not depend on the amounts:
/// changing one noise does not change the other. Seeds may leave the image. O(n).
std::vector<Seed> Damage(std::vector<Seed> seeds, const SeedNoise& noise);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_SEED_NOISE_H_
