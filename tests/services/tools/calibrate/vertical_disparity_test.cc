#include "services/tools/calibrate/vertical_disparity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace sprout::calibrate {
namespace {

constexpr float kDisparityPx = 20;

struct ShiftedPair {
  cv::Mat1b left, right;
  std::vector<Seed> seeds;
};

// Texture, whose right picture is turned about its middle (slope) and lies lower.
ShiftedPair MakePair(double lower_px, double slope = 0) {
  ShiftedPair pair;
  pair.left.create(300, 400);
  cv::RNG(5).fill(pair.left, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(pair.left, pair.left, {}, 1.5);
  cv::normalize(pair.left, pair.left, 0, 255, cv::NORM_MINMAX);
  // (u, v) of the left one is at (u − d, v + lower + slope · (u − 200)).
  const cv::Matx23d right_from_left(1, 0, -kDisparityPx, slope, 1, lower_px - 200 * slope);
  cv::warpAffine(pair.left, pair.right, right_from_left, pair.left.size());
  for (int v = 5; v < 300; v += 10) {
    for (int u = 5; u < 400; u += 10) {
      const auto column = static_cast<float>(u);
      pair.seeds.push_back(
          {.u = column, .v = static_cast<float>(v), .u_right = column - kDisparityPx});
    }
  }
  return pair;
}

TEST(VerticalDisparity, IsFoundToAFractionOfARow) {
  for (const double lower_px : {0.0, 0.4, -1.3, 2.5}) {
    const ShiftedPair pair = MakePair(lower_px);
    const VerticalDisparity found = MeasureVerticalDisparity(pair.left, pair.right, pair.seeds);
    EXPECT_NEAR(found.median_px, lower_px, 0.05);
    EXPECT_GT(found.windows, 400);
    for (const float cell_px : found.cells_px) EXPECT_NEAR(cell_px, lower_px, 0.1);
  }
}

TEST(VerticalDisparity, TheCellsShowARoll) {
  const ShiftedPair pair = MakePair(0, 0.005);
  const VerticalDisparity found = MeasureVerticalDisparity(pair.left, pair.right, pair.seeds);
  ASSERT_EQ(found.cells_px.size(), cv::Size(4, 3));
  EXPECT_NEAR(found.median_px, 0, 0.1);
  for (int row = 0; row < 3; ++row) {
    EXPECT_NEAR(found.cells_px(row, 1), -0.25, 0.1);
    EXPECT_NEAR(found.cells_px(row, 3), 0.75, 0.1);
  }
}

TEST(VerticalDisparity, IsUnknownWithoutTextureSeedsOrAMatch) {
  const ShiftedPair pair = MakePair(0);
  const cv::Mat1b grey(pair.left.size(), uint8_t{100});
  EXPECT_TRUE(std::isnan(MeasureVerticalDisparity(grey, grey, pair.seeds).median_px));
  EXPECT_TRUE(std::isnan(MeasureVerticalDisparity(pair.left, pair.right, {}).median_px));
  const ShiftedPair too_far = MakePair(8);
  const VerticalDisparity found =
      MeasureVerticalDisparity(too_far.left, too_far.right, too_far.seeds);
  EXPECT_LT(found.windows, 20);
  for (const float cell_px : found.cells_px) EXPECT_TRUE(std::isnan(cell_px));
}

}  // namespace
}  // namespace sprout::calibrate
