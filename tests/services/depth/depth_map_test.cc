#include "services/depth/depth_map.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sprout::depth {
namespace {

RectifiedPair Pair(cv::Size size) {
  return {.width = size.width,
          .height = size.height,
          .focal_px = 500,
          .cx = 3.5,
          .cy = 2.5,
          .cx_right = 1.5,
          .baseline_m = 0.1};
}

TEST(DepthMap, HasTheDepthOfEveryDisparityInUnitsOfItsCount) {
  const RectifiedPair pair = Pair({4, 1});
  const DisparityImage disparity(
      cv::Mat1s((cv::Mat1s(1, 4) << 32 * 12, 32 * 27 + 8, 32 * 100, 32 * 3)));
  const DepthImage depth = DepthOf(disparity, pair, 0.001, 1);
  EXPECT_EQ(depth.counts(0, 0), 5000);  // 500 · 0.1 / (12 + 1.5 − 3.5)
  EXPECT_EQ(depth.counts(0, 1), std::lround(50 / 25.25 * 1000));
  EXPECT_EQ(depth.counts(0, 2), std::lround(50 / 98.0 * 1000));
  EXPECT_EQ(depth.counts(0, 3), 50000);
  EXPECT_EQ(depth.metres_per_count, 0.001);
  EXPECT_EQ(depth.focal_px, 500);
  EXPECT_EQ(depth.cx, 3.5);
  EXPECT_DOUBLE_EQ(DepthOf(disparity, pair, 0.0005, 1).Metres(0, 0), 5);
}

TEST(DepthMap, HasNoDepthWithoutADisparityAtInfinityAndBeyondItsRange) {
  const RectifiedPair pair = Pair({5, 1});
  const DisparityImage disparity(
      cv::Mat1s((cv::Mat1s(1, 5) << DisparityImage::kInvalid, 64, 60, -32767, 64 + 24)));
  const DepthImage depth = DepthOf(disparity, pair, 0.001, 1);
  for (int u = 0; u < 4; ++u) EXPECT_EQ(depth.counts(0, u), 0) << u;
  EXPECT_EQ(depth.counts(0, 4), 0) << "66.7 m";
  EXPECT_NEAR(DepthOf(disparity, pair, 0.01, 1).Metres(4, 0), 50 / 0.75, 0.005);
}

TEST(DepthMap, HasTheMedianOfEachBlockWhenItIsSmaller) {
  const RectifiedPair pair = Pair({5, 2});
  const int16_t none = DisparityImage::kInvalid;
  // Depths of 5, 2.5, 1 and 0.5 m.
  const int16_t far = 32 * 12, middle = 32 * 22, near = 32 * 52, nearest = 32 * 102;
  const DisparityImage disparity(cv::Mat1s((cv::Mat1s(2, 5) << far, near, none, near, none,  //
                                            middle, nearest, none, none, near)));
  const DepthImage depth = DepthOf(disparity, pair, 0.001, 2);
  ASSERT_EQ(depth.size(), cv::Size(2, 1));
  EXPECT_EQ(depth.counts(0, 0), 1000) << "the lower one in the middle";
  EXPECT_EQ(depth.counts(0, 1), 0) << "a quarter of the block only";
}

TEST(DepthMap, KeepsTheViewWhenItIsSmaller) {
  const RectifiedPair pair = Pair({8, 8});
  const DepthImage depth = DepthOf(DisparityImage(cv::Mat1s(8, 8, int16_t{320})), pair, 0.001, 4);
  ASSERT_EQ(depth.size(), cv::Size(2, 2));
  // The middle of the first block, column 1.5, is column 0 now.
  EXPECT_DOUBLE_EQ((0 - depth.cx) / depth.focal_px, (1.5 - pair.cx) / pair.focal_px);
  EXPECT_DOUBLE_EQ((1 - depth.cy) / depth.focal_px, (5.5 - pair.cy) / pair.focal_px);
}

}  // namespace
}  // namespace sprout::depth
