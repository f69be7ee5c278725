#ifndef SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_
#define SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_

#include <span>
#include <vector>

#include "common/app/plug.h"
#include "services/prior/prior_estimator.h"

namespace sprout {

/// SEEDS RIG → PRIOR, with LEFT_SEEDS if the configuration says so, and LEFT and RIGHT for the
/// methods that look at them. RIG gives the size of the left image.
class PriorPlug : public Plug {
 public:
  /// @throws ConfigError for a value out of range.
  explicit PriorPlug(const PriorConfig& config) : estimator_(config) {}

  PartSet Inputs() const override;

  /// Always answers; seeds that span no triangle give a map without any disparity, and the outcome
  /// says why.
  Outcome Process(const Frame& frame) override;

 private:
  std::span<const Seed> SeedsOf(const Frame& frame);

  PriorEstimator estimator_;
  std::vector<Seed> seeds_;  // memory
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_
