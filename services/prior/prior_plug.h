#ifndef SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_
#define SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_

#include "common/app/plug.h"

namespace sprout {

/// SEEDS RIG → PRIOR. RIG gives the size of the left image, so that LEFT need not travel here.
class PriorPlug : public Plug {
 public:
  PartSet Inputs() const override { return {Part::kSeeds, Part::kRig}; }

  /// Always answers; seeds that span no triangle give a map without any disparity, and the outcome
  /// says why.
  Outcome Process(const Frame& frame) override;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_PRIOR_PLUG_H_
