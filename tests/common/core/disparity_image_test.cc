#include "common/core/disparity_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

}  // namespace
}  // namespace sprout
