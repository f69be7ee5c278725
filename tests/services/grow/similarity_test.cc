#include "services/grow/similarity.h"

#include <gtest/gtest.h>

#include <cmath>

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
}

TEST(Similarity, ExpssdFollowsEquation4ByHand) {
  const double exponent = 500 / (0.1 * (4000 + 6500));  // 0.476190
  EXPECT_DOUBLE_EQ(SlowExpssd(LeftExample(), RightExample(), 4, 2, 1, 0.1), std::exp(-exponent));
  EXPECT_EQ(ExpssdCost(LeftExample(), RightExample(), 0.1).At(4, 2, 1)[1],
            std::lround(exponent * kCostUnit));
}

TEST(Similarity, EpcFollowsEquations5And6ByHand) {
  DisparityImage prior(cv::Size(8, 5));
  prior.counts() = ToCounts(2.5);  // 1.5 px from d = 1
  const double photo = 500 / (0.1 * (4000 + 6500));
  const double deviation = 1.5 * 1.5 / (2 * 2.0 * 2.0);  // σ_p = 2 px
  EXPECT_DOUBLE_EQ(SlowPrior(1, 2.5, 2), std::exp(-deviation));
  const EpcCost epc(LeftExample(), RightExample(), prior, 0.1, 2);
  EXPECT_NEAR(epc.At(4, 2, 1)[1], (photo + deviation) * kCostUnit, 1);
  EXPECT_NEAR(FromCost(epc.At(4, 2, 1)[1]),
              SlowExpssd(LeftExample(), RightExample(), 4, 2, 1, 0.1) * SlowPrior(1, 2.5, 2), 1e-6);
}

TEST(Similarity, TripleHoldsTheDisparitiesOneBelowAtAndOneAbove) {
  const ExpssdCost expssd(LeftExample(), RightExample(), 0.1);
  const CostTriple costs = expssd.At(4, 2, 1);
  EXPECT_NEAR(FromCost(costs[0]), SlowExpssd(LeftExample(), RightExample(), 4, 2, 0, 0.1), 1e-6);
  EXPECT_NEAR(FromCost(costs[2]), SlowExpssd(LeftExample(), RightExample(), 4, 2, 2, 0.1), 1e-6);
  EXPECT_LT(costs[1], costs[0]);
  EXPECT_LT(costs[1], costs[2]);
}

TEST(Similarity, EqualWindowsAreFullySimilar) {
  const cv::Mat1b image = LeftExample();
  EXPECT_EQ(MnccCost(image, image).At(4, 2, 0)[1], 0);
  EXPECT_EQ(ExpssdCost(image, image, 0.1).At(4, 2, 0)[1], 0);
}

TEST(Similarity, FlatWindowsHaveNoCorrelation) {
  const cv::Mat1b flat(5, 8, uint8_t{100});
  EXPECT_EQ(SlowMncc(flat, flat, 4, 2, 1), 0);
  EXPECT_EQ(MnccCost(flat, flat).At(4, 2, 1)[1], kCostUnit);  // 1 − 0
}

TEST(Similarity, TwoBlackWindowsAreAlike) {
  const cv::Mat1b black(5, 8, uint8_t{0});
  EXPECT_EQ(ExpssdCost(black, black, 0.1).At(4, 2, 1)[1], 0);
}

TEST(Similarity, ExpssdDoesNotChangeWithIntensityScale) {
  cv::Mat1b bright_left = LeftExample();
  cv::Mat1b bright_right = RightExample();
  bright_left *= 8;
  bright_right *= 8;
  const ExpssdCost bright(bright_left, bright_right, 0.1);
  const ExpssdCost dark(LeftExample(), RightExample(), 0.1);
  EXPECT_EQ(bright.At(4, 2, 1), dark.At(4, 2, 1));
}

TEST(Similarity, NothingMatchesWhereThePriorIsEmpty) {
  const DisparityImage prior(cv::Size(8, 5));
  const EpcCost epc(LeftExample(), RightExample(), prior, 0.1, 2);
  EXPECT_EQ(epc.At(4, 2, 1), (CostTriple{kNoMatch, kNoMatch, kNoMatch}));
}

TEST(Similarity, BrightestImagesDoNotOverflow) {
  cv::Mat1b left(5, 8, uint8_t{255});
  cv::Mat1b right(5, 8, uint8_t{0});
  EXPECT_EQ(ExpssdCost(left, right, 0.1).At(4, 2, 1)[1], 10 * kCostUnit);  // 1 / 0.1
  left.col(4) = 0;
  EXPECT_EQ(MnccCost(left, left).At(4, 2, 0)[1], 0);
}

TEST(Similarity, LimitIsTheCostOfTheThreshold) {
  EXPECT_EQ(MnccCost::Limit(0.5), kCostUnit / 2);
  EXPECT_EQ(ExpssdCost::Limit(0.5), std::lround(std::log(2.0) * kCostUnit));
  EXPECT_EQ(EpcCost::Limit(0.5), ExpssdCost::Limit(0.5));
}

TEST(Similarity, HugeExponentsSaturateBelowNoMatch) {
  EXPECT_LT(CostFromExponent(1e30), kNoMatch / 2);
  EXPECT_GT(CostFromExponent(1e30), 100 * kCostUnit);
}

}  // namespace
}  // namespace sprout
