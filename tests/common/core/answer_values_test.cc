#include "common/core/answer_values.h"

#include <gtest/gtest.h>

#include <vector>

namespace sprout {
namespace {

const cv::Size kSize(4, 3);

std::optional<std::string> WrongIn(float disparity_px) {
  DisparityImage map(kSize);
  map.counts()(0, 1) = ToCounts(2);
  map.counts()(2, 3) = ToCounts(disparity_px);
  return WrongDisparity(map, -1);
}

TEST(AnswerValues, DisparitiesLieBetweenInfinityAndTheWidth) {
  EXPECT_EQ(WrongIn(-1.03125F),
            "disparity -1.03125 px at (3, 2); allowed is -1 to 3, or no disparity");
  EXPECT_EQ(WrongIn(4), "disparity 4 px at (3, 2); allowed is -1 to 3, or no disparity");
  EXPECT_EQ(WrongIn(-1), std::nullopt);
  EXPECT_EQ(WrongIn(0), std::nullopt);
  EXPECT_EQ(WrongIn(3.96875F), std::nullopt);
  EXPECT_EQ(WrongDisparity(DisparityImage(kSize), -1), std::nullopt);
  // As wide as counts reach, and wider.
  EXPECT_EQ(WrongDisparity(DisparityImage(cv::Mat1s(1, 2000, int16_t{32767})), -1), std::nullopt);
}

TEST(AnswerValues, SeedsLieInBothImagesAndNotBeyondInfinity) {
  const std::vector<Seed> good = {{2, 1, 1}, {3.5F, 2.5F, -0.5F}, {1, -0.5F, 1}};
  EXPECT_EQ(WrongSeed(good, kSize, -1), std::nullopt);
  EXPECT_EQ(WrongSeed({}, kSize, -1), std::nullopt);
  const std::vector<Seed> swapped = {good[0], {.u = 1, .v = 1, .u_right = 3}};
  EXPECT_EQ(WrongSeed(swapped, kSize, -1),
            "seed 1 is (u 1, v 1, u_right 3); allowed are places in both images (4x3) with "
            "u - u_right >= -1");
  for (const Seed& outside :
       {Seed{3.6F, 1, 1}, Seed{2, 2.6F, 1}, Seed{2, 1, -0.6F}, Seed{2, -0.6F, 1}}) {
    EXPECT_NE(WrongSeed({&outside, 1}, kSize, -1), std::nullopt);
  }
}

TEST(AnswerValues, InfinityIsBelowZeroWhereTheRightPrincipalPointLiesFurtherRight) {
  EXPECT_EQ(LeastDisparity({.cx = 10, .cx_right = 18}), -9);
  EXPECT_EQ(LeastDisparity({.cx = 18, .cx_right = 10}), -1);
}

}  // namespace
}  // namespace sprout
