#ifndef SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_
#define SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_

#include "common/app/plug.h"
#include "services/prior/prior_estimator.h"

namespace sprout {

/// SEEDS RIG → PRIOR, and LEFT and RIGHT for the methods that look at them. RIG gives the size of
/// the left image.
class PriorPlug : public Plug {
 public:
  /// @throws ConfigError for a value out of range.
  explicit PriorPlug(const PriorConfig& config) : estimator_(config) {}

  PartSet Inputs() const override;

  /// Always answers; seeds that span no triangle give a map without any disparity, and the outcome
  /// says why.
  Outcome Process(const Frame& frame) override;

 private:
  PriorEstimator estimator_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_
