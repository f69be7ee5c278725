#include "services/tools/evaluate/seed_noise.h"

#include <cmath>
#include <numbers>
#include <random>

namespace sprout::evaluate {
namespace {

// Standard C++ fixes the numbers of the engine but not those of its distributions, which differ
// from library to library.
class RandomNumbers {
 public:
  explicit RandomNumbers(uint64_t seed) : engine_(seed) {}

  // Uniform in (0, 1), the ends excluded.
  double Unit() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; }

  // Uniform in (−1, 1).
  double Symmetric() { return 2 * Unit() - 1; }

  // Standard normal distribution (Box and Muller 1958).
  double Gaussian() {
    const double radius = std::sqrt(-2 * std::log(Unit()));
    return radius * std::cos(2 * std::numbers::pi * Unit());
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace

std::vector<Seed> Damage(std::vector<Seed> seeds, const SeedNoise& noise) {
  if (noise.disparity_px == 0 && noise.jitter_px == 0) return seeds;  // not even rounded
  RandomNumbers random(noise.seed);
  for (Seed& seed : seeds) {
    if (seed.origin != SeedOrigin::kTof) continue;
    const double disparity = seed.disparity() + noise.disparity_px * random.Gaussian();
    const double u = seed.u + noise.jitter_px * random.Symmetric();
    const double v = seed.v + noise.jitter_px * random.Symmetric();
    seed.u = static_cast<float>(u);
    seed.v = static_cast<float>(v);
    seed.u_right = static_cast<float>(u - disparity);
    seed.sigma_px = static_cast<float>(std::hypot(seed.sigma_px, noise.disparity_px));
  }
  return seeds;
}

}  // namespace sprout::evaluate
