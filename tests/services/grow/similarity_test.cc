#include "services/grow/similarity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "services/grow/growth_band.h"
#include "tests/common/core/even_prior.h"
#include "tests/services/grow/slow_growth.h"

namespace sprout {
namespace {

double FromCost(int32_t cost) { return std::exp(-static_cast<double>(cost) / kCostUnit); }

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

// Costs as growth computes them.
class GrowthCosts {
 public:
  GrowthCosts(GrowConfig::Similarity similarity, const cv::Mat1b& left, const cv::Mat1b& right,
              const DisparityImage& prior = {}) {
    GrowConfig config;
    config.set_similarity(similarity);
    config.set_sigma_s_squared(0.1);
    config.set_sigma_p_px(2);
    config.set_sigma_p_noise(0);
    rule_ = MakeGrowthRule(config);
    band_.Resize(left.size(), 0, rule_, GrowthBand::Kind::kOpen);
    prior_ = EvenPrior(prior, 1);
    PrepareBand({left, right, prior_}, rule_, band_);
  }

  CostTriple At(int u, int v, int d) const { return CostsAt(rule_, band_, u, v, d); }
  int32_t limit() const { return rule_.limit; }
  const GrowthBand& band() const { return band_; }

 private:
  GrowthRule rule_;
  PriorMap prior_;
  GrowthBand band_;
};

// By hand, for (u, v) = (4, 2) and d = 1, so that both bright columns are in the middle:
//   Σ wL = 20·10 + 5·20 = 300, Σ wR = 20·10 + 5·30 = 350
//   Σ wL² = 20·100 + 5·400 = 4000, Σ wR² = 20·100 + 5·900 = 6500
//   Σ wL·wR = 20·100 + 5·600 = 5000, Σ (wL − wR)² = 5·100 = 500
//   25·cov = 5000 − 300·350/25 = 800, 25·var = 4000 − 3600 = 400 and 6500 − 4900 = 1600
TEST(Similarity, MnccFollowsEquation1ByHand) {
  const double expected = 2.0 * 800 / (400 + 1600);  // 0.8
  EXPECT_DOUBLE_EQ(SlowMncc(LeftExample(), RightExample(), 4, 2, 1), expected);
  EXPECT_EQ(MnccCost(LeftExample(), RightExample()).At(4, 2, 1)[1],
            std::lround((1 - expected) * kCostUnit));
  EXPECT_NEAR(GrowthCosts(GrowConfig::MNCC, LeftExample(), RightExample()).At(4, 2, 1)[1],
              (1 - expected) * kCostUnit, 1);
}

TEST(Similarity, ExpssdFollowsEquation4ByHand) {
  const double exponent = 500 / (0.1 * (4000 + 6500));  // 0.476190
  EXPECT_DOUBLE_EQ(SlowExpssd(LeftExample(), RightExample(), 4, 2, 1, 0.1), std::exp(-exponent));
  EXPECT_NEAR(GrowthCosts(GrowConfig::EXPSSD, LeftExample(), RightExample()).At(4, 2, 1)[1],
              exponent * kCostUnit, 1);
}

TEST(Similarity, EpcFollowsEquations5And6ByHand) {
  DisparityImage prior(cv::Size(8, 5));
  prior.counts() = ToCounts(2.5);  // 1.5 px from d = 1
  const double photo = 500 / (0.1 * (4000 + 6500));
  const double deviation = 1.5 * 1.5 / (2 * 2.0 * 2.0);  // σ_p = 2 px
  EXPECT_DOUBLE_EQ(SlowPrior(1, 2.5, 2), std::exp(-deviation));
  const GrowthCosts epc(GrowConfig::EPC, LeftExample(), RightExample(), prior);
  EXPECT_NEAR(epc.At(4, 2, 1)[1], (photo + deviation) * kCostUnit, 2);
  EXPECT_NEAR(FromCost(epc.At(4, 2, 1)[1]),
              SlowExpssd(LeftExample(), RightExample(), 4, 2, 1, 0.1) * SlowPrior(1, 2.5, 2), 2e-6);
}

TEST(Similarity, TripleHoldsTheDisparitiesOneBelowAtAndOneAbove) {
  const GrowthCosts expssd(GrowConfig::EXPSSD, LeftExample(), RightExample());
  const CostTriple costs = expssd.At(4, 2, 1);
  EXPECT_NEAR(FromCost(costs[0]), SlowExpssd(LeftExample(), RightExample(), 4, 2, 0, 0.1), 1e-6);
  EXPECT_NEAR(FromCost(costs[2]), SlowExpssd(LeftExample(), RightExample(), 4, 2, 2, 0.1), 1e-6);
  EXPECT_LT(costs[1], costs[0]);
  EXPECT_LT(costs[1], costs[2]);
}

TEST(Similarity, EqualWindowsAreFullySimilar) {
  const cv::Mat1b image = LeftExample();
  EXPECT_EQ(MnccCost(image, image).At(4, 2, 0)[1], 0);
  for (const auto similarity : {GrowConfig::MNCC, GrowConfig::EXPSSD}) {
    EXPECT_EQ(GrowthCosts(similarity, image, image).At(4, 2, 0)[1], 0);
  }
}

TEST(Similarity, FlatWindowsHaveNoCorrelation) {
  const cv::Mat1b flat(5, 8, uint8_t{100});
  EXPECT_EQ(SlowMncc(flat, flat, 4, 2, 1), 0);
  EXPECT_EQ(MnccCost(flat, flat).At(4, 2, 1)[1], kCostUnit);  // 1 − 0
  EXPECT_EQ(GrowthCosts(GrowConfig::MNCC, flat, flat).At(4, 2, 1)[1], kCostUnit);
}

TEST(Similarity, TwoBlackWindowsAreAlike) {
  const cv::Mat1b black(5, 8, uint8_t{0});
  EXPECT_EQ(GrowthCosts(GrowConfig::EXPSSD, black, black).At(4, 2, 1)[1], 0);
}

TEST(Similarity, ExpssdDoesNotChangeWithIntensityScale) {
  cv::Mat1b bright_left = LeftExample();
  cv::Mat1b bright_right = RightExample();
  bright_left *= 8;
  bright_right *= 8;
  const GrowthCosts bright(GrowConfig::EXPSSD, bright_left, bright_right);
  const GrowthCosts dark(GrowConfig::EXPSSD, LeftExample(), RightExample());
  EXPECT_EQ(bright.At(4, 2, 1), dark.At(4, 2, 1));
}

TEST(Similarity, NothingMatchesWhereThePriorIsEmpty) {
  DisparityImage prior(cv::Size(8, 5));
  prior.counts()(2, 3) = 0;
  const GrowthCosts epc(GrowConfig::EPC, LeftExample(), RightExample(), prior);
  EXPECT_EQ(epc.band().row(2).left[3].disparity, LeftPixel::kFree);
  EXPECT_EQ(epc.band().row(2).left[4].disparity, LeftPixel::kClosed);
}

TEST(Similarity, WindowsThatLeaveTheImageAreExcluded) {
  const GrowthCosts expssd(GrowConfig::EXPSSD, LeftExample(), RightExample());
  EXPECT_EQ(expssd.At(4, 2, 2)[2], kExcludedCost);  // d = 3: column 1
  EXPECT_LT(expssd.At(4, 2, 2)[1], kExcludedCost);
  EXPECT_EQ(expssd.At(4, 2, 0)[0], kExcludedCost);  // d = −1
}

TEST(Similarity, BrightestImagesDoNotOverflow) {
  cv::Mat1b left(5, 8, uint8_t{255});
  cv::Mat1b right(5, 8, uint8_t{0});
  EXPECT_EQ(GrowthCosts(GrowConfig::EXPSSD, left, right).At(4, 2, 1)[1],
            10 * kCostUnit);  // 1 / 0.1
  left.col(4) = 0;
  EXPECT_EQ(MnccCost(left, left).At(4, 2, 0)[1], 0);
  EXPECT_EQ(GrowthCosts(GrowConfig::MNCC, left, left).At(4, 2, 0)[1], 0);
}

TEST(Similarity, LimitIsTheCostOfTheThreshold) {
  EXPECT_EQ(MnccCost::Limit(0.5), kCostUnit / 2);
  const GrowthCosts mncc(GrowConfig::MNCC, LeftExample(), RightExample());  // τ = 0.5
  EXPECT_EQ(mncc.limit(), kCostUnit / 2);
  const GrowthCosts expssd(GrowConfig::EXPSSD, LeftExample(), RightExample());
  EXPECT_EQ(expssd.limit(), std::lround(std::log(2.0) * kCostUnit));
}

TEST(Similarity, HugeExponentsSaturateBelowNoMatch) {
  EXPECT_LT(CostFromExponent(1e30), kNoMatch / 2);
  EXPECT_GT(CostFromExponent(1e30), 100 * kCostUnit);
}

}  // namespace
}  // namespace sprout
