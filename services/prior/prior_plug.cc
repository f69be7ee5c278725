#include "services/prior/prior_plug.h"

#include <utility>

namespace sprout {

PartSet PriorPlug::Inputs() const {
  PartSet inputs{Part::kSeeds, Part::kRig};
  if (estimator_.uses_left_seeds()) inputs.Add(Part::kLeftSeeds);
  if (estimator_.uses_left()) inputs.Add(Part::kLeft);
  if (estimator_.uses_right()) inputs.Add(Part::kRight);
  return inputs;
}

std::span<const Seed> PriorPlug::SeedsOf(const Frame& frame) {
  if (!estimator_.uses_left_seeds()) return frame.seeds->seeds;
  Join(frame.seeds->seeds, frame.left_seeds->seeds, seeds_);
  return seeds_;
}

Outcome PriorPlug::Process(const Frame& frame) {
  const cv::Size size = frame.rig->pair.size();
  Result<DisparityImage> prior = estimator_.Compute(frame.left, frame.right, SeedsOf(frame), size);
  Outcome outcome;
  if (!prior) {
    outcome.degenerate = prior.error().text;
    prior = DisparityImage(size);
  }
  outcome.outputs.push_back({Part::kPrior, std::move(*prior)});
  return outcome;
}

}  // namespace sprout
