#include "services/prior/prior_plug.h"

#include <utility>

#include "services/prior/prior.h"

namespace sprout {

Outcome PriorPlug::Process(const Frame& frame) {
  const cv::Size size = frame.rig->pair.size();
  Result<DisparityImage> prior = InterpolateSeeds(frame.seeds->seeds, size);
  Outcome outcome;
  if (!prior) {
    outcome.degenerate = prior.error().text;
    prior = DisparityImage(size);
  }
  outcome.outputs.push_back({Part::kPrior, std::move(*prior)});
  return outcome;
}

}  // namespace sprout
