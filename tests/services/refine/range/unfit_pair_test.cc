// What becomes of range points beside a pair whose images do not fit each other.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <span>
#include <vector>

#include "services/refine/range/range_bias.h"
#include "services/refine/refiner.h"
#include "tests/services/refine/range/wall.h"

namespace sprout::refine {
namespace {

// A camera that is covered in part, and one that is blinded, say nothing of the ranges.
TEST(UnfitPair, BelievesAGoodSensorBesideABadCamera) {
  Wall covered;
  covered.right(cv::Rect(0, 0, kWallSize.width / 2, kWallSize.height)) = 0;
  Wall blinded;
  blinded.right = 2 * blinded.right;
  for (const Wall* wall : {&covered, &blinded}) {
    const SeedSet set = wall->Refine(RefineConfig::FIELD);
    EXPECT_GT(set.seeds.size(), 4000U);
    EXPECT_GT(ShareWithin(set, 0.4), 0.97);
  }
}

// Rows that are off, the image of another scene, a camera out of focus, one that loses rows: where
// stereo matches it does so at the points.
TEST(UnfitPair, BelievesASensorThatTheImagesContradictNoMoreThanEachOther) {
  Wall wall;
  Wall rows;
  const cv::Mat1f down = (cv::Mat1f(2, 3) << 1, 0, 0, 0, 1, 4);
  cv::warpAffine(rows.right, rows.right, down, kWallSize, cv::INTER_LINEAR, cv::BORDER_REFLECT);
  Wall other;
  cv::flip(other.right, other.right, 0);
  Wall blurred;
  cv::GaussianBlur(blurred.right, blurred.right, {}, 2);
  Wall striped;
  for (int v = 0; v < kWallSize.height; ++v) {
    if (v / 10 % 2 == 1) striped.right.row(v) = 128;
  }
  for (const Wall* unfit : {&rows, &other, &blurred, &striped}) {
    RefineConfig config;
    Refiner refiner(config);
    const auto set = refiner.Compute(unfit->left, unfit->right, unfit->tof, TofProjector(wall.rig));
    EXPECT_TRUE(refiner.found().range_error.pair_unfit);
    EXPECT_EQ(set->contradicted, 0);
    EXPECT_GT(set->seeds.size(), 4000U);
    EXPECT_GT(ShareWithin(*set, 0.4), 0.97);
  }
}

// Of a sensor that wraps beyond some column: whether all of it is refused, or the pair at fault,
// where stereo matches in that upper part of the picture alone.
RangeError WithFewMatches(int wraps_from, double part) {
  Wall wall;
  wall.Measure([&](const cv::Point2d& at, double depth_m) {
    return at.x < wraps_from ? depth_m : 0.5 * depth_m;
  });
  std::vector<Seed> matches;
  for (int v = 4; v < part * kWallSize.height; v += 5) {
    for (int u = 45; u < kWallSize.width - 5; u += 5) {
      const auto right = static_cast<float>(u - TruthPx(u));
      matches.push_back({.u = static_cast<float>(u), .v = static_cast<float>(v), .u_right = right});
    }
  }
  int behind = 0;
  std::vector<ProjectedPoint> points = TofProjector(wall.rig).Project(wall.tof, behind);
  const TofSurface surface(wall.rig, points);
  return RangeBias().Apply(
      {.left = wall.left, .right = wall.right, .rig = wall.rig, .surface = surface},
      {.matches = [&] { return std::span<const Seed>(matches); }}, points);
}

TEST(UnfitPair, RefusesASensorIfStereoMatchesElsewhereInPartOfThePicture) {
  const RangeError few = WithFewMatches(350, 0.45);
  EXPECT_NEAR(few.contradicted_share, 0.35, 0.05);
  const RangeError all = WithFewMatches(0, 0.3);
  EXPECT_GT(all.contradicted_share, 0.95);
  for (const RangeError& error : {few, all}) {
    EXPECT_TRUE(error.rejected);
    EXPECT_FALSE(error.pair_unfit);
  }
  for (const int wraps_from : {350, 0}) {
    const RangeError error = WithFewMatches(wraps_from, 0.12);
    EXPECT_FALSE(error.rejected);
    EXPECT_TRUE(error.pair_unfit);
  }
}

// The wall beside a right camera that is turned, and has another focal length.
Wall WallBeside(double turn_deg, double scale) {
  Wall wall;
  const cv::Mat moved = cv::getRotationMatrix2D(cv::Point2f(kWallSize) / 2, turn_deg, scale);
  cv::warpAffine(wall.right.clone(), wall.right, moved, kWallSize, cv::INTER_LINEAR,
                 cv::BORDER_REFLECT);
  return wall;
}

// Columns are off, too, by 1.2 px and more: no reason to move points, but for larger errors.
TEST(UnfitPair, MovesNoRightPointsBesideAPairWhoseColumnsAreOff) {
  RefineConfig config;
  config.set_stereo_seeds(false);
  for (const Wall& wall : {WallBeside(0.4, 1), WallBeside(0, 1.01)}) {
    Refiner refiner(config);
    const auto set = refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig));
    EXPECT_TRUE(refiner.found().range_error.IsUnknown());
    EXPECT_EQ(set->contradicted, 0);
    EXPECT_GT(ShareWithin(*set, 0.1), 0.97);
  }
  Wall wall = WallBeside(0.4, 1);
  wall.Measure([&](const cv::Point2d&, double depth_m) { return depth_m + 0.25; });
  Refiner refiner(config);
  const auto set = refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig));
  EXPECT_TRUE(refiner.found().range_error.rows_unfit);
  EXPECT_GT(ShareWithin(*set, 0.8), 0.97);
}

TEST(UnfitPair, SaysHowFarStereoMayBeOffBesideSuchAPair) {
  Wall wall = WallBeside(0.8, 1);
  const int half = wall.tof.depth_m.cols / 2;
  wall.tof.depth_m.colRange(half, wall.tof.depth_m.cols) = 0;
  Refiner refiner{RefineConfig()};
  const auto set = refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig));
  const double columns_px = refiner.found().range_error.columns_px;
  EXPECT_GE(columns_px, 1);
  int matches = 0;
  for (const Seed& seed : set->seeds) {
    if (seed.origin != SeedOrigin::kStereo) continue;
    ++matches;
    EXPECT_GE(seed.sigma_px, columns_px);
  }
  EXPECT_GT(matches, 500);
}

// Of a pair that matches nearly nowhere such a curve says nothing.
TEST(UnfitPair, BelievesPointsThatAreFarOffBesideAPairThatMatchesNowhere) {
  Wall wall;
  const cv::Rect other(0, 150, kWallSize.width, kWallSize.height - 150);
  cv::flip(wall.right(other).clone(), wall.right(other), 0);
  wall.Measure(
      [&](const cv::Point2d& at, double depth_m) { return at.x < 150 ? 1.3 * depth_m : 0; });
  int behind = 0;
  const std::vector<ProjectedPoint> points = TofProjector(wall.rig).Project(wall.tof, behind);
  std::vector<ProjectedPoint> kept = points;
  const TofSurface surface(wall.rig, points);
  const RangeError error = RangeBias().Apply(
      {.left = wall.left, .right = wall.right, .rig = wall.rig, .surface = surface},
      {.matches = [] { return std::span<const Seed>(); }}, kept);
  EXPECT_TRUE(error.pair_unfit);
  EXPECT_FALSE(error.RejectsAll());
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(kept[i].seed.disparity(), points[i].seed.disparity());
  }
}

// Texture that runs down to the right: four rows further up or down all is 16 px aside, where
// these ranges expect it. Stereo matches on its own rows.
TEST(UnfitPair, BelievesThePairWhereWrongRangesFitOtherRows) {
  Wall wall;
  for (int v = 1; v < kWallSize.height; ++v) {
    for (int u = 0; u < kWallSize.width; ++u) {
      wall.left(v, u) =
          wall.left(0, (u + kWallSize.width - 4 * v % kWallSize.width) % kWallSize.width);
    }
  }
  wall.ShowOnTheRight();
  const RectifiedPair& pair = wall.rig.pair;
  wall.Measure([&](const cv::Point2d&, double depth_m) {
    return pair.DepthFromDisparity(pair.DisparityFromDepth(depth_m) - 16);
  });
  RefineConfig config;
  Refiner refiner(config);
  const auto set = refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig));
  EXPECT_TRUE(refiner.found().range_error.rejected);
  EXPECT_FALSE(refiner.found().range_error.pair_unfit);
  EXPECT_GT(ShareWithin(*set, 0.5), 0.9);
}

}  // namespace
}  // namespace sprout::refine
