#include "services/prior/prior_plug.h"

#include <utility>

#include "common/core/image.h"

namespace sprout::prior {

PartSet PriorPlug::Inputs() const {
  PartSet inputs{Part::kSeeds, Part::kRig, Part::kLeft};
  if (estimator_.uses_left_seeds()) inputs.Add(Part::kLeftSeeds);
  if (estimator_.uses_images()) inputs.Add(Part::kRight);
  return inputs;
}

std::span<const Seed> PriorPlug::SeedsOf(const Frame& frame) {
  if (!estimator_.uses_left_seeds()) return frame.seeds->seeds;
  Join(frame.seeds->seeds, frame.left_seeds->seeds, seeds_);
  return seeds_;
}

Result<PriorMap> PriorPlug::Estimate(const Frame& frame) {
  const cv::Size calibrated = frame.rig->pair.size();
  if (frame.left.size() != calibrated) {
    return Fail("LEFT of " + SizeText(frame.left.size()) + ": allowed is the calibrated size " +
                SizeText(calibrated));
  }
  return estimator_.Compute(frame.left, frame.right, SeedsOf(frame), calibrated);
}

Outcome PriorPlug::Process(const Frame& frame) {
  Result<PriorMap> prior = Estimate(frame);
  Outcome outcome;
  if (!prior) {
    outcome.degenerate = prior.error().text;
    prior = PriorMap(frame.left.size());
  }
  outcome.outputs.push_back({Part::kPrior, std::move(*prior)});
  return outcome;
}

}  // namespace sprout::prior
