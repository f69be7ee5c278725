#pragma once

#include <span>
#include <vector>

#include "common/config/stage_parts.h"
#include "common/core/stage_adapter.h"
#include "services/prior/prior_estimator.h"

namespace sprout::prior {

/// SEEDS LEFT RIG → PRIOR, with LEFT_SEEDS if the configuration says so, and RIGHT for the method
/// that looks at images.
class PriorAdapter : public StageAdapter {
 public:
  /// @throws ConfigError for a value out of range.
  explicit PriorAdapter(const PriorConfig& config)
      : inputs_(InputsOf(config)), estimator_(config) {}

  PartSet Inputs() const override { return inputs_; }

  /// Where seeds have negative disparities, in a wider frame (Widened()). Always answers, with a
  /// map of the size of LEFT. Seeds that span no triangle, or images of another size than the
  /// calibrated one, give a map without any disparity, and the result says why.
  StageResult Process(const Frame& frame) override;

 private:
  StageResult ProcessNonNegative(const Frame& frame);
  std::span<const Seed> SeedsOf(const Frame& frame);
  Result<PriorMap> Estimate(const Frame& frame);

  PartSet inputs_;
  PriorEstimator estimator_;
  std::vector<Seed> seeds_;  // memory
};

}  // namespace sprout::prior
