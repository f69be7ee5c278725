#include "services/depth/map_filter.h"

#include <gtest/gtest.h>

#include "services/depth/scan.h"

namespace sprout::depth {
namespace {

// f·b = 10 px·m: disparities of 2, 4, 5 and 10 px are 5, 2.5, 2 and 1 m.
constexpr RectifiedPair kFilteredPair{
    .width = 4, .height = 3, .focal_px = 100, .cx = 1, .cy = 1, .cx_right = 1, .baseline_m = 0.1};

class MapFilterTest : public ::testing::Test {
 protected:
  // Row 2 has no disparity in its last column.
  MapFilterTest() {
    for (int v = 0; v < 3; ++v) {
      for (int u = 0; u < 4; ++u) {
        map_.counts()(v, u) = static_cast<int16_t>(32 * kDisparities[u]);
        confidence_(v, u) = static_cast<uint8_t>(100 * v + 10 * u);
      }
    }
    map_.counts()(2, 3) = DisparityImage::kInvalid;
  }

  // What is left, row by row: '#' and '.'.
  std::string Left(const FilterRules& rules) {
    const DisparityImage kept = MapFilter(rules).Apply(map_, kFilteredPair, confidence_, counts_);
    std::string text;
    for (int v = 0; v < 3; ++v) {
      for (int u = 0; u < 4; ++u) {
        text += kept.IsValid(u, v) ? '#' : '.';
        EXPECT_TRUE(!kept.IsValid(u, v) || kept.counts()(v, u) == map_.counts()(v, u));
      }
      text += v < 2 ? "/" : "";
    }
    EXPECT_EQ(counts_.pixels, 11);
    EXPECT_EQ(counts_.pixels - counts_.LeftOut(), kept.CountValid());
    return text;
  }

  static constexpr int kDisparities[] = {2, 4, 5, 10};
  DisparityImage map_{cv::Size(4, 3)};
  cv::Mat1b confidence_ = cv::Mat1b(3, 4);
  DepthCounts counts_;
};

TEST_F(MapFilterTest, IsOffByDefault) {
  EXPECT_TRUE(MapFilter({}).IsOff());
  EXPECT_EQ(Left({}), "####/####/###.");
  EXPECT_EQ(counts_, DepthCounts{.pixels = 11});
}

TEST_F(MapFilterTest, LeavesOutWhatIsTooNearOrTooFar) {
  EXPECT_EQ(Left({.min_m = 2, .max_m = 2.5}), ".##./.##./.##.");
  EXPECT_EQ(counts_, (DepthCounts{.pixels = 11, .near = 2, .far = 3}));
}

TEST_F(MapFilterTest, CountsWhatIsAtInfinityAsFar) {
  map_.counts()(0, 0) = 0;
  EXPECT_EQ(Left({.max_m = 100}), ".###/####/###.");
  EXPECT_EQ(Left({.min_m = 0.5}), "####/####/###.");
}

TEST_F(MapFilterTest, KeepsARectangleWithItsBorder) {
  EXPECT_EQ(Left({.region = {{2, 2}, {1, 1}}}), "..../.##./.##.");
  EXPECT_EQ(counts_, (DepthCounts{.pixels = 11, .outside = 7}));
}

TEST_F(MapFilterTest, KeepsAPolygonThatMayLieOutsideTheImage) {
  EXPECT_EQ(Left({.region = {{0, 0}, {2, 0}, {0, 2}}}), "###./##../#...");
  EXPECT_EQ(Left({.region = {{-9, -9}, {9, -9}, {9, 0}, {-9, 0}}}), "####/..../....");
}

// Of the left camera as the robot, at 1 m over its origin: x forward, y left, z up. The second row
// is at the camera's height; a column is z/100 m.
TEST_F(MapFilterTest, KeepsABoxInTheRobotsFrame) {
  Pose base_from_left = LevelFromLeft();
  base_from_left.translation_m = {0, 0, 1};
  const Eigen::AlignedBox3d box(Eigen::Vector3d(1.5, -0.021, 0.99), Eigen::Vector3d(10, 0, 2));
  // x = 5, 2.5, 2, 1; y = (1 − u) x / 100 = 0.05, 0, −0.02, −0.02; z = 1 + (1 − v) x / 100.
  EXPECT_EQ(Left({.box = box, .base_from_left = base_from_left}), ".##./.##./....");
  EXPECT_EQ(counts_.outside, 7);
}

TEST_F(MapFilterTest, LeavesOutWhatIsUnsure) {
  EXPECT_EQ(Left({.min_confidence = 110}), "..../.###/###.");
  EXPECT_EQ(counts_, (DepthCounts{.pixels = 11, .unsure = 5}));
}

TEST_F(MapFilterTest, CountsAPixelForTheFirstRuleThatLeavesItOut) {
  EXPECT_EQ(Left({.min_m = 2, .region = {{0, 1}, {3, 2}}, .min_confidence = 110}),
            "..../.##./###.");
  EXPECT_EQ(counts_, (DepthCounts{.pixels = 11, .near = 2, .outside = 3, .unsure = 1}));
}

TEST(MapFilter, LeavesOutFlyingPoints) {
  DisparityImage map(cv::Size(6, 1));
  const int disparities[] = {2, 2, 20, 60, 60, 60};
  for (int u = 0; u < 6; ++u) map.counts()(0, u) = static_cast<int16_t>(32 * disparities[u]);
  RectifiedPair pair = kFilteredPair;
  pair.width = 6;
  pair.height = 1;
  DepthCounts counts;
  const DisparityImage kept = MapFilter({.remove_flying = true}).Apply(map, pair, {}, counts);
  EXPECT_EQ(counts, (DepthCounts{.pixels = 6, .flying = 1}));
  EXPECT_FALSE(kept.IsValid(2, 0));
}

}  // namespace
}  // namespace sprout::depth
