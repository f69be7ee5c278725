#pragma once

#include <cstdint>
#include <vector>

#include "common/config/config.h"
#include "common/core/frame.h"
#include "common/core/seed.h"
#include "services/pipeline/chain.h"
#include "services/tools/evaluate/rivals/rival.h"
#include "services/tools/evaluate/scene.h"

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
std::vector<Seed> AddNoise(std::vector<Seed> seeds, const SeedNoise& noise);

/// How long the stages took, ms; 0 = the method has no such stage.
struct StageTimes {
  double refine_ms = 0;
  double prior_ms = 0;
  double grow_ms = 0;
  double fill_ms = 0;   ///< gap filling, and the confidence where the configuration asks for it
  double total_ms = 0;  ///< from the images and the ToF image to the map
};

/// A method's result for a scene.
struct MethodOutput {
  cv::Mat1f map_px;      ///< disparity of every pixel of the left image, px; NaN = none
  cv::Mat1b confidence;  ///< Part::kConfidence, or what else ranks its pixels; empty = none does
  cv::Mat1b sigma;       ///< Part::kSigma of the map; empty = the confidence is no probability
  StageTimes ms;
};

/// Settings of the methods.
struct ChainSettings {
  SproutConfig config;   ///< effective
  SeedNoise noise;       ///< added to the refined seeds, not timed
  FgsSettings fgs = {};  ///< of method fgs
};

/// A frame with the images, the ToF image and the rig of a scene.
Frame FrameOf(const Scene& scene);

/// The chain on a frame of the scene, with Scene::WithRange() and the noise; see Chain::Run(). A
/// stage that refuses its input gives an empty result, which is scored as wrong everywhere.
void RunSteps(const Scene& scene, const ChainSettings& settings, ChainStep last, Frame& frame,
              StageTimes& ms);

/// The whole chain.
/// @param frame  of the scene; may have seeds already.
MethodOutput RunChain(const Scene& scene, const ChainSettings& settings, Frame frame);

}  // namespace sprout::evaluate
