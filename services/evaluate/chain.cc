#include "services/evaluate/chain.h"

#include "services/grow/confidence.h"
#include "services/grow/gap_filler.h"
#include "services/grow/grower.h"
#include "services/grow/harris_seeds.h"
#include "services/prior/prior_estimator.h"
#include "services/refine/refiner.h"

namespace sprout {
namespace {

std::vector<Seed> FindGrowthSeeds(const Scene& scene, const GrowConfig& config,
                                  const RefinedSeeds& refined, StageTimes& ms) {
  if (config.seeds() == GrowConfig::TOF) return refined.seeds;
  return Timed(ms.grow_ms, [&] {
    return MatchHarrisCorners(scene.left_grey, scene.right_grey, config.harris());
  });
}

DisparityImage RunGrow(const Scene& scene, const GrowConfig& config, const std::vector<Seed>& seeds,
                       const PriorMap& prior, StageTimes& ms) {
  Grower grower(config);
  return Timed(ms.grow_ms, [&] {
    return grower.Compute(scene.left_grey, scene.right_grey, seeds, prior)
        .value_or(DisparityImage(scene.size()));
  });
}

}  // namespace

RefinedSeeds RunRefine(const Scene& scene, const ChainSettings& settings, StageTimes& ms) {
  Refiner refiner(scene.WithRange(settings.config.refine()));
  const SeedSet correspondences = Timed(ms.refine_ms, [&] {
    return refiner.Compute(scene.left_grey, scene.right_grey, scene.frame.tof, scene.projector)
        .value_or(SeedSet());
  });
  RefinedSeeds refined;
  Join(correspondences.seeds, refiner.left_seeds().seeds, refined.all);
  refined.all = Damage(std::move(refined.all), settings.noise);
  refined.seeds.assign(refined.all.begin(),
                       refined.all.begin() + std::ssize(correspondences.seeds));
  return refined;
}

PriorMap RunPrior(const Scene& scene, const PriorConfig& config, const RefinedSeeds& refined,
                  StageTimes& ms) {
  PriorEstimator estimator(config);
  const std::vector<Seed>& seeds = estimator.uses_left_seeds() ? refined.all : refined.seeds;
  return Timed(ms.prior_ms, [&] {
    return estimator.Compute(scene.frame.left, scene.frame.right, seeds, scene.size())
        .value_or(PriorMap(scene.size()));
  });
}

MethodOutput RunChain(const Scene& scene, const ChainSettings& settings) {
  const GrowConfig& config = settings.config.grow();
  const bool needs_prior =
      config.similarity() == GrowConfig::EPC || config.fill() == GrowConfig::PRIOR;
  const bool needs_tof = needs_prior || config.seeds() == GrowConfig::TOF;
  MethodOutput output;
  StageTimes& ms = output.ms;
  const RefinedSeeds refined = needs_tof ? RunRefine(scene, settings, ms) : RefinedSeeds();
  const PriorMap prior =
      needs_prior ? RunPrior(scene, settings.config.prior(), refined, ms) : PriorMap();
  const std::vector<Seed> seeds = FindGrowthSeeds(scene, config, refined, ms);
  const DisparityImage grown = RunGrow(scene, config, seeds, prior, ms);
  DisparityImage filled =
      Timed(ms.fill_ms, [&] { return FillGaps(grown, config.fill(), prior.disparity); });
  ms.total_ms = ms.refine_ms + ms.prior_ms + ms.grow_ms + ms.fill_ms;
  output.confidence =
      Confidence(scene.left_grey, scene.right_grey, seeds, grown, filled, config.sigma_s_squared());
  DropUnsure(output.confidence, config.min_confidence(), filled);
  output.map_px = ToPx(filled);
  return output;
}

}  // namespace sprout
