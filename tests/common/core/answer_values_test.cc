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
  return WrongDisparity(map);
}

TEST(AnswerValues, DisparitiesLieBetweenZeroAndTheWidth) {
  EXPECT_EQ(WrongIn(-0.03125F),
            "disparity -0.03125 px at (3, 2); allowed is 0 to 3, or no disparity");
  EXPECT_EQ(WrongIn(4), "disparity 4 px at (3, 2); allowed is 0 to 3, or no disparity");
  EXPECT_EQ(WrongIn(0), std::nullopt);
  EXPECT_EQ(WrongIn(3.96875F), std::nullopt);
  EXPECT_EQ(WrongDisparity(DisparityImage(kSize)), std::nullopt);
  // As wide as counts reach, and wider.
  EXPECT_EQ(WrongDisparity(DisparityImage(cv::Mat1s(1, 2000, int16_t{32767}))), std::nullopt);
}

TEST(AnswerValues, SeedsLieInBothImagesAndNotBehindInfinity) {
  const std::vector<Seed> good = {{2, 1, 1}, {3.5F, 2.5F, -0.5F}, {1, -0.5F, 1}};
  EXPECT_EQ(WrongSeed(good, kSize), std::nullopt);
  EXPECT_EQ(WrongSeed({}, kSize), std::nullopt);
  const std::vector<Seed> swapped = {good[0], {.u = 1, .v = 1, .u_right = 2}};
  EXPECT_EQ(WrongSeed(swapped, kSize),
            "seed 1 is (u 1, v 1, u_right 2); allowed are places in both images (4x3) with "
            "u >= u_right");
  for (const Seed& outside :
       {Seed{3.6F, 1, 1}, Seed{2, 2.6F, 1}, Seed{2, 1, -0.6F}, Seed{2, -0.6F, 1}}) {
    EXPECT_NE(WrongSeed({&outside, 1}, kSize), std::nullopt);
  }
}

}  // namespace
}  // namespace sprout
