#include "common/core/window_sums.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sprout {
namespace {

TEST(SumWindows, AddsUpTheWindowsAroundTheTwoPixels) {
  // 9 pixels of 1 to 9 in the left one; the right one has twice as much, a pixel to the right.
  const cv::Mat1b left = (cv::Mat1b(3, 4) << 1, 2, 3, 255, 4, 5, 6, 255, 7, 8, 9, 255);
  const cv::Mat1b right = (cv::Mat1b(3, 4) << 255, 2, 4, 6, 255, 8, 10, 12, 255, 14, 16, 18);
  const WindowSums sums = SumWindows<1>(left, right, {1, 1}, {2, 1});
  EXPECT_EQ(sums.left, 45);
  EXPECT_EQ(sums.right, 90);
  EXPECT_EQ(sums.left_squares, 285);
  EXPECT_EQ(sums.right_squares, 4 * 285);
  EXPECT_EQ(sums.products, 2 * 285);
}

TEST(SumWindows, HasRoomForTheLargestWindowsOfWhite) {
  const cv::Mat1b white(181, 181, uint8_t{255});
  const WindowSums sums = SumWindows<90>(white, white, {90, 90}, {90, 90});
  EXPECT_EQ(sums.products, 181 * 181 * 255 * 255);
  EXPECT_EQ(sums.left, 181 * 181 * 255);
}

TEST(NoiseVariance, IsThatOfTheNoiseOnASlope) {
  cv::Mat1b slope(70, 70);
  for (int v = 0; v < slope.rows; ++v) {
    for (int u = 0; u < slope.cols; ++u) slope(v, u) = static_cast<uint8_t>(30 + 2 * u + v);
  }
  const cv::Point middle(35, 35);
  EXPECT_EQ(NoiseVariance<30>(slope, middle), 0);
  cv::Mat1s noise(slope.size());
  cv::RNG(1).fill(noise, cv::RNG::NORMAL, 0, 6);
  cv::Mat1b noisy;
  cv::add(slope, noise, noisy, cv::noArray(), CV_8U);
  EXPECT_NEAR(NoiseVariance<30>(noisy, middle), 36, 4);
}

TEST(IsInside, IsTrueWhereARoundedPositionHasItsWindowInTheImage) {
  const cv::Size size(20, 10);
  for (double v = -3; v < 13; v += 0.25) {
    for (double u = -3; u < 23; u += 0.25) {
      // Halves are on the edge of two pixels, so they do not count.
      if (u - std::floor(u) == 0.5 || v - std::floor(v) == 0.5) continue;
      const cv::Point pixel(cvRound(u), cvRound(v));
      const cv::Rect window(pixel - cv::Point(2, 2), cv::Size(5, 5));
      const bool fits = (window & cv::Rect({}, size)) == window;
      EXPECT_EQ(IsInside(u, v, size, 1.5), fits) << u << " " << v;
    }
  }
}

TEST(IsInside, IsFalseForWhatNoPixelHas) {
  const cv::Size size(20, 10);
  EXPECT_FALSE(IsInside(NAN, 5, size, 0));
  EXPECT_FALSE(IsInside(5, NAN, size, 0));
  EXPECT_FALSE(IsInside(1e30, 5, size, 0));
  EXPECT_FALSE(IsInside(5, -INFINITY, size, 0));
}

TEST(IsInside, HasAMarginForEitherDirection) {
  const cv::Size size(20, 10);
  EXPECT_TRUE(IsInside(3.1, 1.1, size, 3, 1));
  EXPECT_FALSE(IsInside(2.9, 1.1, size, 3, 1));
  EXPECT_FALSE(IsInside(3.1, 0.9, size, 3, 1));
  EXPECT_TRUE(IsInside(15.9, 7.9, size, 3, 1));
  EXPECT_FALSE(IsInside(16.1, 7.9, size, 3, 1));
  EXPECT_FALSE(IsInside(15.9, 8.1, size, 3, 1));
}

}  // namespace
}  // namespace sprout
