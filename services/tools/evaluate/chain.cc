#include "services/tools/evaluate/chain.h"

#include <chrono>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

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

// Times the steps, and adds the noise to the seeds outside of the times.
class Watch : public ChainObserver {
 public:
  Watch(const SeedNoise& noise, StageTimes& ms) : noise_(noise), ms_(ms) {}

  void Begins(ChainStep /*step*/) override { begin_ = Clock::now(); }

  void Ended(ChainStep step) override {
    const double ms = std::chrono::duration<double, std::milli>(Clock::now() - begin_).count();
    TimeOf(step) += ms;
    ms_.total_ms += ms;
  }

  // Damages both lists of seeds as one, so that they share the random numbers.
  void Refined(SeedSet& seeds, SeedSet& left_seeds) override {
    std::vector<Seed> all;
    Join(seeds.seeds, left_seeds.seeds, all);
    all = AddNoise(std::move(all), noise_);
    const auto end_of_seeds = all.begin() + std::ssize(seeds.seeds);
    seeds.seeds.assign(all.begin(), end_of_seeds);
    left_seeds.seeds.assign(end_of_seeds, all.end());
  }

 private:
  using Clock = std::chrono::steady_clock;

  double& TimeOf(ChainStep step) {
    switch (step) {
      case ChainStep::kRefine:
        return ms_.refine_ms;
      case ChainStep::kPrior:
        return ms_.prior_ms;
      case ChainStep::kGrow:
        return ms_.grow_ms;
      case ChainStep::kFinish:
      case ChainStep::kTemporal:
        break;
    }
    return ms_.fill_ms;
  }

  const SeedNoise& noise_;
  StageTimes& ms_;
  Clock::time_point begin_;
};

}  // namespace

std::vector<Seed> AddNoise(std::vector<Seed> seeds, const SeedNoise& noise) {
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

Frame FrameOf(const Scene& scene) {
  Frame frame;
  frame.left = scene.frame.left;
  frame.right = scene.frame.right;
  frame.tof = scene.frame.tof;
  frame.tof_zones = scene.frame.tof_zones;
  frame.rig = scene.projector.rig();
  return frame;
}

void RunSteps(const Scene& scene, const ChainSettings& settings, ChainStep last, Frame& frame,
              StageTimes& ms) {
  SproutConfig config = settings.config;
  *config.mutable_refine() = scene.WithRange(config.refine());
  Watch watch(settings.noise, ms);
  Chain(config).Run(frame, watch, last);
}

MethodOutput RunChain(const Scene& scene, const ChainSettings& settings, Frame frame) {
  MethodOutput output;
  RunSteps(scene, settings, ChainStep::kFinish, frame, output.ms);
  output.map_px = ToPx(*frame.disparity);
  output.confidence = frame.confidence;
  output.sigma = frame.sigma;
  return output;
}

}  // namespace sprout::evaluate
