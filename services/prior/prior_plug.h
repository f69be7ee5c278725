#ifndef SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_
#define SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_

#include <span>
#include <vector>

#include "common/core/plug.h"
#include "services/prior/prior_estimator.h"

namespace sprout::prior {

/// SEEDS LEFT RIG → PRIOR, with LEFT_SEEDS if the configuration says so, and RIGHT for the method
/// that looks at images. LEFT is joined by the other method, too: an answer has the pixels of an
/// image that came, never as many as the few bytes of a calibration claim.
class PriorPlug : public Plug {
 public:
  /// @throws ConfigError for a value out of range.
  explicit PriorPlug(const PriorConfig& config) : estimator_(config) {}

  PartSet Inputs() const override;

  /// Always answers, with a map of the size of LEFT; seeds that span no triangle, or images of
  /// another size than the calibrated one, give one without any disparity, and the outcome says
  /// why.
  Outcome Process(const Frame& frame) override;

 private:
  std::span<const Seed> SeedsOf(const Frame& frame);
  Result<PriorMap> Estimate(const Frame& frame);

  PriorEstimator estimator_;
  std::vector<Seed> seeds_;  // memory
};

}  // namespace sprout::prior

#endif  // SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_
