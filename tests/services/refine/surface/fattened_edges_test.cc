#include "services/refine/surface/fattened_edges.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "services/refine/refiner.h"
#include "tests/services/refine/refine_scene.h"

namespace sprout::refine {
namespace {

// What is left of two boxes before a wall that are so many ToF pixels larger to all sides.
std::vector<ProjectedPoint> Left(int fat, Fattening& fattening) {
  BoxScene scene;
  const int side = 2 * fat + 1;
  cv::erode(scene.tof.depth_m, scene.tof.depth_m, cv::Mat1b::ones(side, side));
  int behind = 0;
  std::vector<ProjectedPoint> points = TofProjector(scene.rig).Project(scene.tof, behind);
  const auto all = static_cast<double>(points.size());
  std::vector<ProjectedPoint> before;
  fattening =
      DropFattened(TofSurface(scene.rig, points), scene.left, scene.right, 0, points, before);
  EXPECT_EQ(static_cast<double>(before.size()), fattening ? all : 0);
  EXPECT_NEAR(fattening.dropped_share, 1 - static_cast<double>(points.size()) / all, 1e-9);
  return points;
}

TEST(FattenedEdges, AreDropped) {
  for (const int fat : {1, 2, 3}) {
    Fattening fattening;
    const auto left = Left(fat, fattening);
    EXPECT_GE(fattening.width, fat);
    EXPECT_LE(fattening.width, fat + 1);
    EXPECT_GT(left.size(), 4000U);
    const auto wrong = std::ranges::count_if(left, [](const ProjectedPoint& point) {
      return point.seed.disparity() > BoxScene::DisparityAt(5 * point.tof_u, 5 * point.tof_v) + 1;
    });
    // Beside the left edges, 16 and 18 pixels high, the right camera does not see the wall.
    EXPECT_LE(wrong, 34);
  }
}

TEST(FattenedEdges, AreNoneOfARightSensor) {
  Fattening fattening;
  EXPECT_EQ(Left(0, fattening).size(), 4800U);
  EXPECT_FALSE(fattening);
}

// A patch of so few points would be believed of a sensor whose edges are right.
TEST(FattenedEdges, ShowThatPatchesMayBeWrongAsWell) {
  for (const int side : {1, 5}) {
    BoxScene scene;
    cv::erode(scene.tof.depth_m, scene.tof.depth_m, cv::Mat1b::ones(side, side));
    cv::Mat1f patch = scene.tof.depth_m({64, 44, 11, 11});
    for (float& depth_m : patch) {
      const RectifiedPair& pair = scene.rig.pair;
      depth_m =
          static_cast<float>(pair.DepthFromDisparity(pair.DisparityFromDepth(double{depth_m}) - 3));
    }
    Refiner refiner{RefineConfig()};
    ASSERT_TRUE(refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig)));
    const double patch_share = static_cast<double>(patch.total()) / (80 * 60);
    const double moved = refiner.found().range_error.far_from_curve_share;
    if (side == 1) {
      EXPECT_EQ(moved, 0);
    } else {
      EXPECT_NEAR(moved, patch_share, patch_share / 2);
    }
  }
}

TEST(FattenedEdges, AreNotBelievedOfImagesThatFitNothing) {
  BoxScene scene;
  cv::flip(scene.right, scene.right, 1);
  Refiner refiner{RefineConfig()};
  const auto set = refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig));
  ASSERT_TRUE(set);
  EXPECT_TRUE(refiner.found().range_error.pair_unfit);
  EXPECT_FALSE(refiner.found().fattening);
  EXPECT_EQ(set->contradicted, 0);
}

}  // namespace
}  // namespace sprout::refine
