#ifndef SPROUT_SERVICES_GROW_GROWTH_RULE_H_
#define SPROUT_SERVICES_GROW_GROWTH_RULE_H_

#include <array>
#include <cstdint>

#include "common/config/config.h"
#include "common/core/disparity_image.h"
#include "common/core/prior_map.h"

namespace sprout {

/// What decides on a correspondence: the configuration in the units in which growth computes.
struct GrowthRule {
  GrowConfig::Similarity similarity = GrowConfig::EPC;
  int32_t limit = 0;  ///< largest accepted cost
  bool sub_pixel = false;
  float photo_scale = 0;  ///< cost of a normalised difference of 1

  /// By the counts of the prior's standard deviation, PriorMap::sigma: the cost of a distance of
  /// one count from the prior, which grows as its square; and the distance, counts, beyond which
  /// that cost alone is above the limit. The surest prior comes first.
  std::array<float, kMaxSigmaCounts + 1> prior_scales{};
  std::array<int, kMaxSigmaCounts + 1> prior_reaches{};

  /// Least standard deviation, counts, for which the prior leaves a pixel more than the two whole
  /// disparities on either side of it; kMaxSigmaCounts + 1 when none does. Below, σ_p is
  /// sigma_p_px.
  int least_open = 0;
};

GrowthRule MakeGrowthRule(const GrowConfig& config);

/// σ_p of eq. (5) at a pixel, px: what the configuration makes of the prior's standard deviation σ
/// there,
///   σ_p = max(sigma_p_px, sigma_p_noise · √(max(0, σ² − sigma_p_sure_px²))).      (S1)
double SigmaP(const GrowConfig& config, double sigma_px);

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_GROWTH_RULE_H_
