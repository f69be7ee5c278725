#include "services/grow/paper/growth_rule.h"

#include <cmath>

#include "services/grow/paper/similarity-inl.h"

namespace sprout::grow {
namespace {

int32_t WholeCost(double exponent) { return static_cast<int32_t>(exponent * kCostUnit + 0.5); }

// Largest distance, counts, whose cost is within the limit.
int ReachOf(float prior_scale, int32_t limit) {
  int least = 0;
  int beyond = UINT16_MAX + 1;
  while (beyond - least > 1) {
    const int middle = (least + beyond) / 2;
    const float cost = HWY_NAMESPACE::PriorCost(static_cast<float>(middle), prior_scale);
    (cost < static_cast<float>(limit + 1) ? least : beyond) = middle;
  }
  return least;
}

}  // namespace

double SigmaP(const GrowConfig& config, double sigma_px) {
  const double sure = config.sigma_p_sure_px();
  const double unsure = std::sqrt(std::max(0.0, sigma_px * sigma_px - sure * sure));
  return std::max(config.sigma_p_px(), config.sigma_p_noise() * unsure);
}

GrowthRule MakeGrowthRule(const GrowConfig& config) {
  const bool mncc = config.similarity() == GrowConfig::MNCC;
  GrowthRule rule;
  rule.similarity = config.similarity();
  rule.sub_pixel = config.sub_pixel();
  rule.limit = WholeCost(mncc ? 1 - config.threshold() : -std::log(config.threshold()));
  while (rule.KeyOf(rule.limit) >= kKeys) ++rule.key_shift;
  rule.levels_per_cost = (kLevels << GrowthRule::kLevelFraction) / (rule.limit + 1);
  rule.photo_scale = static_cast<float>(kCostUnit / (mncc ? 1 : config.sigma_s_squared()));
  rule.min_wide_sigma = rule.min_open_sigma = kMaxSigmaCounts + 1;
  for (size_t counts = rule.prior_scales.size(); counts-- > 0;) {
    const double sigma_px = SigmaToPx(static_cast<uint8_t>(counts));
    const double sigma_p_counts = SigmaP(config, sigma_px) * DisparityImage::kCountsPerPixel;
    const auto scale = static_cast<float>(kCostUnit / (2 * sigma_p_counts * sigma_p_counts));
    rule.prior_scales[counts] = scale;
    rule.prior_reaches[counts] = ReachOf(scale, rule.limit);
    const auto is_beyond = [&](int px) {
      return rule.prior_reaches[counts] >= px * DisparityImage::kCountsPerPixel;
    };
    if (is_beyond(1)) rule.min_wide_sigma = static_cast<int>(counts);
    if (is_beyond(kSweptPx)) rule.min_open_sigma = static_cast<int>(counts);
  }
  if (rule.similarity != GrowConfig::EPC) rule.min_wide_sigma = rule.min_open_sigma = 0;
  // Pixels with two candidates all have one scale.
  std::fill_n(rule.prior_scales.begin(), rule.min_wide_sigma, rule.prior_scales[0]);
  std::fill_n(rule.prior_reaches.begin(), rule.min_wide_sigma, rule.prior_reaches[0]);
  return rule;
}

}  // namespace sprout::grow
