#include "services/evaluate/chain.h"

#include <utility>

#include "services/grow/grow_plug.h"
#include "services/prior/prior_plug.h"
#include "services/refine/refine_plug.h"

namespace sprout::evaluate {
namespace {

// Both lists are one for the random numbers.
void AddNoise(const SeedNoise& noise, Frame& frame) {
  std::vector<Seed>& seeds = frame.seeds->seeds;
  std::vector<Seed>& left_seeds = frame.left_seeds->seeds;
  std::vector<Seed> all;
  Join(seeds, left_seeds, all);
  all = Damage(std::move(all), noise);
  const auto end_of_seeds = all.begin() + std::ssize(seeds);
  seeds.assign(all.begin(), end_of_seeds);
  left_seeds.assign(end_of_seeds, all.end());
}

}  // namespace

Frame FrameOf(const Scene& scene) {
  Frame frame;
  frame.left = scene.frame.left;
  frame.right = scene.frame.right;
  frame.tof = scene.frame.tof;
  frame.rig = scene.projector.rig();
  return frame;
}

void RunRefine(const Scene& scene, const ChainSettings& settings, Frame& frame, StageTimes& ms) {
  refine::RefinePlug refine(scene.WithRange(settings.config.refine()));
  Timed(ms.refine_ms, [&] { return RunPlug(refine, frame); });
  AddNoise(settings.noise, frame);
}

void RunPrior(const PriorConfig& config, Frame& frame, StageTimes& ms) {
  prior::PriorPlug prior(config);
  Timed(ms.prior_ms, [&] { return RunPlug(prior, frame); });
}

MethodOutput RunChain(const Scene& scene, const ChainSettings& settings) {
  grow::GrowPlug grow(settings.config.grow());
  Frame frame = FrameOf(scene);
  MethodOutput output;
  StageTimes& ms = output.ms;
  const bool needs_prior = grow.Inputs().Has(Part::kPrior);
  if (needs_prior || grow.Inputs().Has(Part::kSeeds)) RunRefine(scene, settings, frame, ms);
  if (needs_prior) RunPrior(settings.config.prior(), frame, ms);
  const grow::GrowPlug::Growth growth = Timed(ms.grow_ms, [&] { return grow.Grow(frame); });
  Outcome outcome = Timed(ms.fill_ms, [&] { return grow.Finish(frame, growth); });
  for (Output& part : outcome.outputs) SetPart(frame, part.part, std::move(part.value));
  ms.total_ms = ms.refine_ms + ms.prior_ms + ms.grow_ms + ms.fill_ms;
  output.map_px = ToPx(*frame.disparity);
  output.confidence = frame.confidence;
  return output;
}

}  // namespace sprout::evaluate
