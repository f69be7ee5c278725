#include "services/grow/growth_rule.h"

#include <cmath>

#include "services/grow/similarity.h"

namespace sprout {
namespace {

// Largest distance whose cost is within the limit.
int ReachOf(float prior_scale, int32_t limit) {
  int reach = 0;
  while (reach < UINT16_MAX && PriorCost(reach + 1, prior_scale) < static_cast<float>(limit + 1)) {
    ++reach;
  }
  return reach;
}

}  // namespace

GrowthRule MakeGrowthRule(const GrowConfig& config, double sigma_p_px) {
  GrowthRule rule;
  rule.similarity = config.similarity();
  rule.sub_pixel = config.sub_pixel();
  if (config.similarity() == GrowConfig::MNCC) {
    rule.limit = CostFromExponent(1 - config.threshold());
    rule.photo_scale = kCostUnit;
    return rule;
  }
  rule.limit = CostFromExponent(-std::log(config.threshold()));
  rule.photo_scale = static_cast<float>(kCostUnit / config.sigma_s_squared());
  const double sigma_p_counts = sigma_p_px * DisparityImage::kCountsPerPixel;
  rule.prior_scale = static_cast<float>(kCostUnit / (2 * sigma_p_counts * sigma_p_counts));
  rule.prior_reach = ReachOf(rule.prior_scale, rule.limit);
  return rule;
}

}  // namespace sprout
