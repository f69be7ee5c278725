// Equations by hand, and Alg. 1 by hand. What runs for EPC must equal this file's subject:
// fast_growth_test.cc.
#include "services/grow/paper/plain_growth.h"

#include <gtest/gtest.h>

#include "services/grow/paper/plain_costs.h"
#include "tests/common/core/even_prior.h"
#include "tests/services/grow/grow_scenes.h"

namespace sprout::grow {
namespace {

// Images of 8 × 5 that are easy to sum by hand: 10 everywhere but for one brighter column, 20 in
// column 4 of the left image, 30 in column 3 of the right one.
cv::Mat1b LeftExample() {
  cv::Mat1b image(5, 8, uint8_t{10});
  image.col(4) = 20;
  return image;
}
cv::Mat1b RightExample() {
  cv::Mat1b image(5, 8, uint8_t{10});
  image.col(3) = 30;
  return image;
}

// At (4, 2), in kCostUnit.
double CostAt(GrowConfig::Similarity similarity, const cv::Mat1b& left, const cv::Mat1b& right,
              int d, const PriorMap& prior = {}) {
  GrowConfig config = EpcConfig();  // σ_s² = 0.1, σ_p = 2 px
  config.set_similarity(similarity);
  return static_cast<double>(CostOf(MakeGrowthRule(config), {left, right, prior}, {4, 2, d})) /
         kCostUnit;
}

constexpr double kStep = 1.0 / kCostUnit;

// By hand, for (u, v) = (4, 2) and d = 1, so that both bright columns are in the middle:
//   Σ wL = 20·10 + 5·20 = 300, Σ wR = 20·10 + 5·30 = 350
//   Σ wL² = 20·100 + 5·400 = 4000, Σ wR² = 20·100 + 5·900 = 6500
//   Σ wL·wR = 20·100 + 5·600 = 5000, Σ (wL − wR)² = 5·100 = 500
//   25·cov = 5000 − 300·350/25 = 800, 25·var = 4000 − 3600 = 400 and 6500 − 4900 = 1600
TEST(Similarity, MnccFollowsEquation1ByHand) {
  EXPECT_NEAR(CostAt(GrowConfig::MNCC, LeftExample(), RightExample(), 1),
              1 - 2.0 * 800 / (400 + 1600), kStep);
}

TEST(Similarity, ExpssdFollowsEquation4ByHand) {
  EXPECT_NEAR(CostAt(GrowConfig::EXPSSD, LeftExample(), RightExample(), 1),
              500 / (0.1 * (4000 + 6500)), kStep);
}

// d = 0: the bright columns are one apart. Σ (wL − wR)² = 5·(100 + 400) = 2500.
TEST(Similarity, ExpssdFollowsEquation4OneDisparityOff) {
  EXPECT_NEAR(CostAt(GrowConfig::EXPSSD, LeftExample(), RightExample(), 0),
              2500 / (0.1 * (4000 + 6500)), kStep);
}

TEST(Similarity, EpcFollowsEquations5And6ByHand) {
  const double photo = 500 / (0.1 * (4000 + 6500));
  const double deviation = 1.5 * 1.5 / (2 * 2.0 * 2.0);  // 1.5 px from the prior, σ_p = 2 px
  EXPECT_NEAR(CostAt(GrowConfig::EPC, LeftExample(), RightExample(), 1, ConstantPrior({8, 5}, 2.5)),
              photo + deviation, 2 * kStep);
}

TEST(Similarity, EqualWindowsAreFullySimilar) {
  const cv::Mat1b image = LeftExample();
  EXPECT_EQ(CostAt(GrowConfig::MNCC, image, image, 0), 0);
  EXPECT_EQ(CostAt(GrowConfig::EXPSSD, image, image, 0), 0);
}

TEST(Similarity, FlatWindowsHaveNoCorrelation) {
  const cv::Mat1b flat(5, 8, uint8_t{100});
  EXPECT_EQ(CostAt(GrowConfig::MNCC, flat, flat, 1), 1);
}

TEST(Similarity, TwoBlackWindowsAreAlike) {
  const cv::Mat1b black(5, 8, uint8_t{0});
  EXPECT_EQ(CostAt(GrowConfig::EXPSSD, black, black, 1), 0);
}

TEST(Similarity, ExpssdDoesNotChangeWithIntensityScale) {
  cv::Mat1b left = LeftExample(), right = RightExample();
  left *= 8;
  right *= 8;
  EXPECT_EQ(CostAt(GrowConfig::EXPSSD, left, right, 1),
            CostAt(GrowConfig::EXPSSD, LeftExample(), RightExample(), 1));
}

TEST(Similarity, NothingMatchesWhereThePriorIsEmpty) {
  const PriorMap prior(cv::Size(8, 5));
  EXPECT_EQ(CostAt(GrowConfig::EPC, LeftExample(), RightExample(), 1, prior),
            kExcludedCost * kStep);
}

TEST(Similarity, BrightestImagesDoNotOverflow) {
  cv::Mat1b left(5, 8, uint8_t{255});
  const cv::Mat1b right(5, 8, uint8_t{0});
  EXPECT_EQ(CostAt(GrowConfig::EXPSSD, left, right, 1), double{kMaxCost} * kStep);  // of 10
  left.colRange(3, 5) = 0;
  EXPECT_EQ(CostAt(GrowConfig::MNCC, left, left, 0), 0);
}

TEST(Similarity, HugeExponentsAreCutBelowWhatDoesNotFit) {
  GrowConfig config = EpcConfig();
  config.set_sigma_p_px(0.01);
  const PriorMap prior = ConstantPrior({8, 5}, 1000);
  const int32_t cost =
      CostOf(MakeGrowthRule(config), {LeftExample(), RightExample(), prior}, {4, 2, 1});
  EXPECT_EQ(cost, kMaxCost);
  EXPECT_LT(cost, kExcludedCost);
}

// One row of windows. Pixels 4 and 6 of the left image both look like right pixel 3: only the
// better one gets it, and of two equal ones the one that is reached first.
TEST(PlainGrowth, TakesTheBetterSeedFirstAndARightPixelOnce) {
  const cv::Size size(12, 5);
  const cv::Mat1b flat(size, uint8_t{100});  // every disparity fits everywhere
  GrowConfig config = EpcConfig();
  config.set_similarity(GrowConfig::EXPSSD);
  // From (5, 2): left (4, 2) first, then right (6, 2), both with d = 2, and so on to both sides.
  const Correspondence seed{5, 2, 2};
  const DisparityImage map =
      GrowPlainly(MakeGrowthRule(config), {flat, flat, PriorMap()}, {&seed, 1});
  for (int u = 4; u < 10; ++u) EXPECT_EQ(map.Px(u, 2), 2) << u;
  for (const int u : {0, 1, 2, 3, 10, 11}) EXPECT_FALSE(map.IsValid(u, 2)) << u;
  EXPECT_EQ(map.CountValid(), 6) << "the other rows have no window";
}

}  // namespace
}  // namespace sprout::grow
