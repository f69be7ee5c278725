#include "services/grow/paper/growth_rule.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/common/config/with.h"

namespace sprout::grow {
namespace {

GrowthRule Rule(const std::string& config) { return MakeGrowthRule(With<GrowConfig>(config)); }

TEST(GrowthRule, LimitIsTheCostOfTheThreshold) {
  // τ = 0.5 by default.
  EXPECT_EQ(Rule("").limit, std::lround(std::log(2.0) * kCostUnit));
  EXPECT_EQ(Rule("similarity: MNCC").limit, kCostUnit / 2);
  const GrowthRule smallest = Rule("similarity: EXPSSD threshold: 0.001");
  EXPECT_EQ(smallest.limit, std::lround(std::log(1000.0) * kCostUnit));
  EXPECT_LT(smallest.limit, kMaxCost);
}

TEST(GrowthRule, LevelsHaveEqualWidthsUpToTheLimit) {
  const GrowthRule rule = Rule("");
  EXPECT_EQ(rule.LevelOf(0), 0);
  for (int level = 0; level < kLevels; ++level) {
    const double middle = (level + 0.5) / kLevels * rule.limit;
    EXPECT_EQ(rule.LevelOf(static_cast<int32_t>(middle)), level);
  }
  EXPECT_EQ(rule.LevelOf(rule.limit), kLevels - 1);
  EXPECT_EQ(rule.LevelOf(rule.limit + 1), kLevels - 1);
  EXPECT_EQ(rule.LevelOf(kExcludedCost), kLevels - 1);
}

TEST(GrowthRule, KeysOfAcceptedCostsFitInto15Bits) {
  for (const std::string threshold : {"0.001", "0.5", "0.98", "0.999"}) {
    const GrowthRule rule = Rule("threshold: " + threshold);
    EXPECT_LT(rule.KeyOf(rule.limit), kKeys) << threshold;
    EXPECT_TRUE(rule.key_shift == 0 || rule.limit >> (rule.key_shift - 1) >= kKeys) << threshold;
    EXPECT_EQ(rule.KeyOf(0), 0);
  }
  EXPECT_LT(2 * (kKeys - 1) + 1, INT16_MAX);
}

TEST(GrowthRule, WithoutAPriorEveryPixelIsOpen) {
  EXPECT_EQ(Rule("sigma_p_px: 0.7 similarity: EXPSSD").min_open_sigma, 0);
}

TEST(GrowthRule, SigmaPFollowsFormulaS1) {
  auto config = With<GrowConfig>("sigma_p_px: 0.8 sigma_p_noise: 4 sigma_p_sure_px: 0.6");
  EXPECT_EQ(SigmaP(config, 0), 0.8);
  EXPECT_EQ(SigmaP(config, 0.6), 0.8);
  EXPECT_DOUBLE_EQ(SigmaP(config, 1), 4 * 0.8);  // √(1 − 0.36)
  config.set_sigma_p_noise(0);
  EXPECT_EQ(SigmaP(config, 10), 0.8);
}

// With τ = 0.5 a distance of 7 px is within the limit from σ_p = 7 / √(2·ln 2) = 5.945 px on.
TEST(GrowthRule, APixelIsOpenWhereThePriorAlonePassesADistanceOfSevenPixels) {
  EXPECT_EQ(Rule("sigma_p_noise: 0 sigma_p_px: 5.93").min_open_sigma, kMaxSigmaCounts + 1);
  EXPECT_EQ(Rule("sigma_p_noise: 0 sigma_p_px: 5.96").min_open_sigma, 0);
}

// The same for a pixel: 0.849 px.
TEST(GrowthRule, APixelHasMoreThanTwoCandidatesWhereThePriorAlonePassesADistanceOfAPixel) {
  EXPECT_EQ(Rule("sigma_p_noise: 0 sigma_p_px: 0.84").min_wide_sigma, kMaxSigmaCounts + 1);
  EXPECT_EQ(Rule("sigma_p_noise: 0 sigma_p_px: 0.86").min_wide_sigma, 0);
  const GrowthRule rule = Rule("sigma_p_px: 0.8 sigma_p_noise: 1 sigma_p_sure_px: 0");
  EXPECT_EQ(rule.min_wide_sigma, 14);  // of 1/16 px: 0.875; 13 are 0.8125
  EXPECT_EQ(rule.prior_scales[13], rule.prior_scales[0]) << "below, σ_p is sigma_p_px";
  EXPECT_LT(rule.prior_scales[14], rule.prior_scales[13]);
  EXPECT_LT(rule.prior_reaches[13], DisparityImage::kCountsPerPixel);
  EXPECT_GE(rule.prior_reaches[14], DisparityImage::kCountsPerPixel);
}

}  // namespace
}  // namespace sprout::grow
