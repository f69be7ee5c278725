#include "services/tools/evaluate/chain.h"

#include <chrono>
#include <utility>

namespace sprout::evaluate {
namespace {

// Times the steps, and damages the seeds, in no step's time.
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
    all = Damage(std::move(all), noise_);
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
