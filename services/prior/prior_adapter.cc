#include "services/prior/prior_adapter.h"

#include <utility>

#include "common/core/image.h"
#include "common/geometry/widened_frame.h"

namespace sprout::prior {

std::span<const Seed> PriorAdapter::SeedsOf(const Frame& frame) {
  if (!estimator_.uses_left_seeds()) return frame.seeds->seeds;
  Join(frame.seeds->seeds, frame.left_seeds->seeds, seeds_);
  return seeds_;
}

Result<PriorMap> PriorAdapter::Estimate(const Frame& frame) {
  const cv::Size calibrated = frame.rig->pair.size();
  if (frame.left.size() != calibrated) {
    return Fail("LEFT of " + SizeText(frame.left.size()) + ": allowed is the calibrated size " +
                SizeText(calibrated));
  }
  return estimator_.Compute(frame.left, GreyestRight(frame), SeedsOf(frame), calibrated,
                            frame.left_grey);
}

StageResult PriorAdapter::Process(const Frame& frame) {
  const int columns = ColumnsBelowZero(SeedsOf(frame));
  if (columns == 0) return ProcessNonNegative(frame);
  StageResult result = ProcessNonNegative(Widened(frame, columns));
  Narrow(result, columns, frame.left.size());
  return result;
}

StageResult PriorAdapter::ProcessNonNegative(const Frame& frame) {
  Result<PriorMap> prior = Estimate(frame);
  StageResult outcome;
  if (!prior) {
    outcome.degenerate = prior.error().text;
    prior = PriorMap(frame.left.size());
  }
  outcome.outputs.push_back({Part::kPrior, std::move(*prior)});
  return outcome;
}

}  // namespace sprout::prior
