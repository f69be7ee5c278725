#ifndef SPROUT_SERVICES_EVALUATE_CHAIN_H_
#define SPROUT_SERVICES_EVALUATE_CHAIN_H_

#include <chrono>
#include <utility>
#include <vector>

#include "common/config/config.h"
#include "common/core/prior_map.h"
#include "common/core/seed.h"
#include "services/evaluate/rivals/rival.h"
#include "services/evaluate/scene.h"
#include "services/evaluate/seed_noise.h"

namespace sprout {

/// How long the stages took, ms; 0 = the method has no such stage.
struct StageTimes {
  double refine_ms = 0;
  double prior_ms = 0;
  double grow_ms = 0;  ///< Harris corners included where growth starts from them
  double fill_ms = 0;
  double total_ms = 0;  ///< from the images and the ToF image to the map
};

/// What a method made of a scene.
struct MethodOutput {
  cv::Mat1f map_px;      ///< disparity of every pixel of the left image, px; NaN = none
  cv::Mat1b confidence;  ///< Confidence() of the map; empty = the method has none
  StageTimes ms;
};

/// What the methods are run with.
struct ChainSettings {
  SproutConfig config;   ///< effective
  SeedNoise noise;       ///< added to the refined seeds, in no stage's time
  FgsSettings fgs = {};  ///< of method fgs
};

/// Runs a function and adds the time it takes.
template <typename Function>
auto Timed(double& ms, const Function& function) {
  const auto begin = std::chrono::steady_clock::now();
  auto result = function();
  ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

// The stages as the services call them, in process. A stage that refuses its input gives an empty
// result, as its service does; scored, that counts as wrong everywhere.

/// What refinement leaves.
struct RefinedSeeds {
  std::vector<Seed> seeds;  ///< correspondences
  std::vector<Seed> all;    ///< and behind them those that only the left camera sees
};

/// sprout-refine, then the noise.
RefinedSeeds RunRefine(const Scene& scene, const ChainSettings& settings, StageTimes& ms);

/// sprout-prior.
PriorMap RunPrior(const Scene& scene, const PriorConfig& config, const RefinedSeeds& refined,
                  StageTimes& ms);

/// The whole chain; stages whose results growth does not ask for are left out.
MethodOutput RunChain(const Scene& scene, const ChainSettings& settings);

}  // namespace sprout

#endif  // SPROUT_SERVICES_EVALUATE_CHAIN_H_
