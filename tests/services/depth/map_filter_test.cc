#include "services/depth/map_filter.h"

#include <gtest/gtest.h>

#include "services/depth/flying.h"
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
