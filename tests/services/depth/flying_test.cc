#include "services/depth/flying.h"

#include <gtest/gtest.h>

namespace sprout::depth {
namespace {

// Rows of one profile: disparities in px.
DisparityImage Rows(const std::vector<double>& profile, int rows = 9) {
  DisparityImage map(cv::Size(static_cast<int>(profile.size()), rows));
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < map.width(); ++u) {
      map.counts()(v, u) = ToCounts(profile[static_cast<size_t>(u)]);
    }
  }
  return map;
}

// The columns of the middle row that fly.
std::vector<int> FlyingColumns(const cv::Mat1b& flying) {
  std::vector<int> columns;
  for (int u = 0; u < flying.cols; ++u) {
    if (flying(flying.rows / 2, u) != 0) columns.push_back(u);
  }
  return columns;
}

const std::vector<double> kRamp = {10, 10, 10, 10, 10, 15, 20, 25, 30, 30, 30, 30, 30};

TEST(FindFlying, FindsWhatHangsBetweenTwoSurfaces) {
  EXPECT_EQ(FlyingColumns(FindFlying(Rows(kRamp))), (std::vector{5, 6, 7}));
}

TEST(FindFlying, FindsItAlongColumnsToo) {
  const DisparityImage rows = Rows(kRamp);
  DisparityImage columns(cv::Mat1s(rows.counts().t()));
  EXPECT_EQ(FlyingColumns(cv::Mat1b(FindFlying(columns).t())), (std::vector{5, 6, 7}));
}

TEST(FindFlying, KeepsBothEdgesOfAStep) {
  EXPECT_EQ(FlyingColumns(FindFlying(Rows({10, 10, 10, 10, 10, 30, 30, 30, 30, 30}))),
            std::vector<int>());
}

TEST(FindFlying, KeepsThinObjectsInFrontOfASurface) {
  EXPECT_EQ(FlyingColumns(FindFlying(Rows({10, 10, 10, 10, 30, 10, 10, 10, 10}))),
            std::vector<int>());
}

// 0.7 px a pixel: 3 of the 13 columns around are within 1 px.
TEST(FindFlying, KeepsSteepSurfacesAndTakesSteeperOnesForRamps) {
  std::vector<double> steep, steeper;
  for (int u = 0; u < 15; ++u) {
    steep.push_back(5 + 0.7 * u);
    steeper.push_back(5 + 1.25 * u);
  }
  EXPECT_EQ(FlyingColumns(FindFlying(Rows(steep))), std::vector<int>());
  EXPECT_FALSE(FlyingColumns(FindFlying(Rows(steeper))).empty());
}

TEST(FindFlying, LooksNotAtPixelsWithoutADisparity) {
  const double none = -2000;  // out of range
  EXPECT_EQ(FlyingColumns(FindFlying(Rows({10, 10, none, none, none, 15, none, 30, 30, 30}))),
            (std::vector{5}));
  EXPECT_EQ(FlyingColumns(FindFlying(Rows({none, none, none, none, 15, none, none, 30, 30}))),
            std::vector<int>())
      << "nothing is farther";
  EXPECT_EQ(cv::countNonZero(FindFlying(DisparityImage(cv::Size(1, 1)))), 0);
}

}  // namespace
}  // namespace sprout::depth
