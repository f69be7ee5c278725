#ifndef SPROUT_SERVICES_GROW_GROWTH_RULE_H_
#define SPROUT_SERVICES_GROW_GROWTH_RULE_H_

#include <cstdint>

#include "common/config/config.h"
#include "common/core/disparity_image.h"

namespace sprout {

/// What decides on a correspondence: the configuration in the units in which growth computes.
struct GrowthRule {
  GrowConfig::Similarity similarity = GrowConfig::EPC;
  int32_t limit = 0;  ///< largest accepted cost
  bool sub_pixel = false;
  float photo_scale = 0;  ///< cost of a normalised difference of 1
  float prior_scale = 0;  ///< cost of a distance of one count from the prior; grows as its square
  int prior_reach = 0;    ///< counts; farther from the prior its cost alone is beyond the limit

  /// The prior leaves each pixel at most the two whole disparities on either side of it.
  bool two_candidates() const {
    return similarity == GrowConfig::EPC && prior_reach < DisparityImage::kCountsPerPixel;
  }
};

/// @param sigma_p_px  σ_p, px.
GrowthRule MakeGrowthRule(const GrowConfig& config, double sigma_p_px);

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_GROWTH_RULE_H_
