#include "common/core/disparity_image.h"

#include <gtest/gtest.h>

#include "common/core/prior_map.h"
#include "tests/common/core/even_prior.h"

namespace sprout {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

TEST(ToCounts, RoundsToTheNearestCountAndHalvesAwayFromZero) {
  EXPECT_EQ(ToCounts(0), 0);
  EXPECT_EQ(ToCounts(1), 32);
  EXPECT_EQ(ToCounts(-2.5), -80);
  EXPECT_EQ(ToCounts(10.49 / 32), 10);
  EXPECT_EQ(ToCounts(10.5 / 32), 11);
  EXPECT_EQ(ToCounts(-10.49 / 32), -10);
  EXPECT_EQ(ToCounts(-10.5 / 32), -11);
}

TEST(ToCounts, KeepsTheLargestDisparityAndRefusesAnythingBeyond) {
  EXPECT_EQ(ToCounts(DisparityImage::kMaxPx), 32767);
  EXPECT_EQ(ToCounts(-DisparityImage::kMaxPx), -32767);
  EXPECT_EQ(ToCounts(std::nextafter(DisparityImage::kMaxPx, 2000)), DisparityImage::kInvalid);
  EXPECT_EQ(ToCounts(std::nextafter(-DisparityImage::kMaxPx, -2000)), DisparityImage::kInvalid);
  EXPECT_EQ(ToCounts(1024), DisparityImage::kInvalid);
  EXPECT_EQ(ToCounts(1e300), DisparityImage::kInvalid);
}

TEST(ToCounts, GivesNoDisparityForWhatIsNoNumber) {
  EXPECT_EQ(ToCounts(kNan), DisparityImage::kInvalid);
  EXPECT_EQ(ToCounts(kInf), DisparityImage::kInvalid);
  EXPECT_EQ(ToCounts(-kInf), DisparityImage::kInvalid);
}

TEST(DisparityImage, StartsWithoutAnyDisparity) {
  const DisparityImage disparity(cv::Size(4, 3));
  EXPECT_EQ(disparity.width(), 4);
  EXPECT_EQ(disparity.height(), 3);
  EXPECT_EQ(disparity.size(), cv::Size(4, 3));
  EXPECT_FALSE(disparity.empty());
  EXPECT_EQ(disparity.CountValid(), 0);
  EXPECT_FALSE(disparity.IsValid(3, 2));
  EXPECT_TRUE(std::isnan(disparity.Px(3, 2)));
}

TEST(DisparityImage, ReadsAndCountsWhatWasWritten) {
  DisparityImage disparity(cv::Size(4, 3));
  disparity.counts()(2, 1) = ToCounts(7.25);  // row 2, column 1
  disparity.counts()(0, 3) = -32767;
  disparity.counts()(1, 1) = 0;
  EXPECT_EQ(disparity.CountValid(), 3);
  EXPECT_TRUE(disparity.IsValid(1, 2));
  EXPECT_FLOAT_EQ(disparity.Px(1, 2), 7.25F);
  EXPECT_FLOAT_EQ(disparity.Px(3, 0), -1023.96875F);
  EXPECT_EQ(disparity.Px(1, 1), 0.0F);
  EXPECT_FALSE(disparity.IsValid(2, 1));
}

TEST(DisparityImage, WithoutPixelsIsEmptyAndCountsNothing) {
  const DisparityImage disparity;
  EXPECT_TRUE(disparity.empty());
  EXPECT_EQ(disparity.CountValid(), 0);
}

TEST(DisparityImage, SharesItsPixelsWithCopies) {
  DisparityImage disparity(cv::Size(2, 2));
  const DisparityImage copy = disparity;
  disparity.counts()(1, 1) = 64;
  EXPECT_FLOAT_EQ(copy.Px(1, 1), 2.0F);
}

TEST(DisparityImage, GoesToPixelsAndBackWithoutLoss) {
  DisparityImage map(cv::Size(3, 2));
  map.counts()(0, 1) = 1;
  map.counts()(1, 2) = 32767;
  const cv::Mat1f px = ToPx(map);
  EXPECT_EQ(px(0, 1), 1 / 32.F);
  EXPECT_TRUE(std::isnan(px(0, 0)));
  EXPECT_EQ(cv::countNonZero(FromPx(px).counts() != map.counts()), 0);
}

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
