#include "common/core/prior_map.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/common/core/even_prior.h"

namespace sprout {
namespace {

TEST(SigmaToPx, OfAMapIsInfiniteWhereItMayBeAnyLargerOne) {
  const cv::Mat1f px = SigmaToPx((cv::Mat1b(1, 3) << 1, 24, 255));
  EXPECT_EQ(px(0, 0), 0.0625F);
  EXPECT_EQ(px(0, 1), 1.5F);
  EXPECT_EQ(px(0, 2), std::numeric_limits<float>::infinity());
}

TEST(SigmaCounts, RoundToNearestAndNeverSayZero) {
  EXPECT_EQ(SigmaToCounts(1), 16);
  EXPECT_EQ(SigmaToCounts(1.03), 16);
  EXPECT_EQ(SigmaToCounts(1.04), 17);
  EXPECT_EQ(SigmaToCounts(0.001), 1);
  EXPECT_EQ(SigmaToCounts(0), 1);
  EXPECT_EQ(SigmaToCounts(-3), 1);
}

TEST(SigmaCounts, EndAtTheLargest) {
  EXPECT_EQ(SigmaToCounts(15.875), 254);
  EXPECT_EQ(SigmaToCounts(15.9375), 255);
  EXPECT_EQ(SigmaToCounts(1e300), 255);
  EXPECT_EQ(SigmaToCounts(std::numeric_limits<double>::infinity()), 255);
  EXPECT_EQ(SigmaToCounts(std::numeric_limits<double>::quiet_NaN()), 255);
}

TEST(SigmaCounts, GoToPixelsAndBackWithoutLoss) {
  for (int counts = 1; counts <= 255; ++counts) {
    EXPECT_EQ(SigmaToCounts(SigmaToPx(static_cast<uint8_t>(counts))), counts);
  }
  EXPECT_EQ(SigmaToPx(kMaxSigmaCounts), 15.9375F);
}

TEST(PriorMap, OfASizeHasNoDisparityAndKnowsNothing) {
  const PriorMap prior(cv::Size(4, 3));
  EXPECT_EQ(prior.size(), cv::Size(4, 3));
  EXPECT_EQ(prior.disparity.CountValid(), 0);
  EXPECT_EQ(cv::countNonZero(prior.sigma == kMaxSigmaCounts), 12);
  EXPECT_TRUE(PriorMap().empty());
}

TEST(EvenPrior, IsEquallySureWhereverThereIsADisparity) {
  DisparityImage map(cv::Size(3, 2));
  map.counts()(0, 1) = ToCounts(7);
  map.counts()(1, 2) = 0;
  const PriorMap prior = EvenPrior(map, 0.5);
  const cv::Mat1b expected = (cv::Mat1b(2, 3) << 255, 8, 255, 255, 255, 8);
  EXPECT_EQ(cv::countNonZero(prior.sigma != expected), 0);
  EXPECT_EQ(prior.disparity.counts()(0, 1), ToCounts(7));
}

}  // namespace
}  // namespace sprout
