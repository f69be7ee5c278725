#include "services/refine/range/range_bias.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "services/refine/findings.h"
#include "services/refine/refiner.h"
#include "tests/services/refine/range/wall.h"

namespace sprout::refine {
namespace {

// A bump in the middle of the image, as multi-path makes: too far.
double Bumped(const RectifiedPair& pair, const cv::Point2d& at, double depth_m,
              double bump_px = 3) {
  const double across = (at.x - 300) / 40;
  const double down = (at.y - 170) / 40;
  return pair.DepthFromDisparity(pair.DisparityFromDepth(depth_m) -
                                 bump_px * std::exp(-(across * across + down * down) / 2));
}

TEST(RangeBias, LeavesARightSensorAlone) {
  const Wall wall;
  EXPECT_EQ(wall.Refine(RefineConfig::FIELD), wall.Refine(RefineConfig::OFF));
  EXPECT_EQ(wall.Refine(RefineConfig::CURVE), wall.Refine(RefineConfig::OFF));
}

TEST(RangeBias, FindsWhatAllRangesAreOffBy) {
  Wall wall;
  for (const double error_m : {0.04, -0.04}) {
    wall.Measure([&](const cv::Point2d&, double depth_m) { return depth_m + error_m; });
    EXPECT_LT(ShareWithin(wall.Refine(RefineConfig::OFF), 0.4), 0.1);
    EXPECT_GT(ShareWithin(wall.Refine(RefineConfig::CURVE), 0.4), 0.97) << error_m;
    EXPECT_GT(ShareWithin(wall.Refine(RefineConfig::FIELD), 0.4), 0.97) << error_m;
  }
}

TEST(RangeBias, FindsAnErrorThatChangesWithTheRange) {
  Wall wall;
  wall.Measure([&](const cv::Point2d&, double depth_m) {
    return depth_m + 0.04 * std::sin(2 * CV_PI * depth_m / 1.25);
  });
  EXPECT_LT(ShareWithin(wall.Refine(RefineConfig::OFF), 0.5), 0.6);
  EXPECT_GT(ShareWithin(wall.Refine(RefineConfig::FIELD), 0.5), 0.9);
}

TEST(RangeBias, SaysItsCurveInMetres) {
  Wall wall;
  wall.Measure([&](const cv::Point2d&, double depth_m) { return depth_m + 0.04; });
  RefineConfig config;
  Refiner refiner(config);
  ASSERT_TRUE(refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig)));
  const RangeError& error = refiner.found().range_error;
  EXPECT_FALSE(error.curve_is_zero);
  ASSERT_GE(error.curve.size(), 3U);
  for (const RangeKnot& knot : error.curve) {
    EXPECT_NEAR(knot.error_m, 0.04, 0.01) << knot.depth_m;
    // All votes share a quarter of a px.
    const double shared_m = 0.25 * knot.depth_m * knot.depth_m / 54;
    EXPECT_GT(knot.sigma_m, shared_m);
    EXPECT_LT(knot.sigma_m, std::hypot(shared_m, 0.02)) << knot.depth_m;
  }
  EXPECT_GT(error.moved_share, 0.99);
  EXPECT_GT(error.far_moved_share, 0.9);  // 0.04 m are 0.3 px at the far end
  EXPECT_EQ(error.far_from_curve_share, 0);
  EXPECT_FALSE(error.rejected);
}

// A piece of texture is too little to move all points, but enough not to believe them.
TEST(RangeBias, BelievesCoarsePointsOnlyWhereImagesShowThemRight) {
  constexpr double kErrorM = 0.03;
  Wall wall(1, kCoarseStep);
  for (const Seed& seed : wall.Refine(RefineConfig::FIELD, kErrorM).seeds) {
    EXPECT_NEAR(seed.sigma_px, 0.05, 0.01);
  }
  wall.KeepTextureIn({200, 150, 60, 60});
  wall.Measure([&](const cv::Point2d&, double depth_m) { return depth_m + kErrorM; });
  const SeedSet set = wall.Refine(RefineConfig::FIELD, kErrorM);
  ASSERT_GT(set.seeds.size(), 1000U);
  EXPECT_LT(ShareWithin(set, 0.1), 0.1);
  for (const Seed& seed : set.seeds) EXPECT_GT(seed.sigma_px, 0.1) << seed.u << " " << seed.v;
}

TEST(RangeBias, FollowsWhatTheSceneAddsBetweenCoarsePoints) {
  Wall wall(1, kCoarseStep);
  wall.Measure(
      [&](const cv::Point2d& at, double depth_m) { return Bumped(wall.rig.pair, at, depth_m); });
  EXPECT_LT(ShareWithin(wall.Refine(RefineConfig::CURVE), 0.75), 0.96);
  EXPECT_GT(ShareWithin(wall.Refine(RefineConfig::FIELD), 0.75), 0.98);
}

TEST(RangeBias, FollowsWhatTheSceneAddsOnlyWithTheField) {
  Wall wall;
  wall.Measure(
      [&](const cv::Point2d& at, double depth_m) { return Bumped(wall.rig.pair, at, depth_m); });
  const double off = ShareWithin(wall.Refine(RefineConfig::OFF), 0.75);
  EXPECT_LT(off, 0.92);
  EXPECT_GT(ShareWithin(wall.Refine(RefineConfig::FIELD), 0.75), 0.98);
  EXPECT_LT(ShareWithin(wall.Refine(RefineConfig::CURVE), 0.75), 0.96);
}

// Costs reach 8 px; its flanks show it to a second look.
TEST(RangeBias, FollowsMoreThanItsCostsReach) {
  Wall wall;
  constexpr double kBumpPx = 11;
  wall.Measure([&](const cv::Point2d& at, double depth_m) {
    return Bumped(wall.rig.pair, at, depth_m, kBumpPx);
  });
  EXPECT_LT(ShareWithin(wall.Refine(RefineConfig::OFF), 0.75), 0.87);
  EXPECT_GT(ShareWithin(wall.Refine(RefineConfig::FIELD), 0.75), 0.98);
}

// As on a plain lampshade: a few grey levels, and hardly any noise beside them.
TEST(RangeBias, FollowsWhatTheSceneAddsWhereTextureIsWeak) {
  Wall wall(0.04);
  wall.Measure(
      [&](const cv::Point2d& at, double depth_m) { return Bumped(wall.rig.pair, at, depth_m); });
  EXPECT_LT(ShareWithin(wall.Refine(RefineConfig::OFF), 0.75), 0.92);
  EXPECT_GT(ShareWithin(wall.Refine(RefineConfig::FIELD), 0.75), 0.97);
}

TEST(RangeBias, SaysWhichShareOfThePointsWasMovedFar) {
  Wall wall;
  wall.Measure(
      [&](const cv::Point2d& at, double depth_m) { return Bumped(wall.rig.pair, at, depth_m); });
  Refiner refiner{RefineConfig()};
  ASSERT_TRUE(refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig)));
  // The bump is more than 0.25 px within 2.23 of its standard deviations of 40 px.
  const double true_share = CV_PI * 2.23 * 40 * 2.23 * 40 / kWallSize.area();
  EXPECT_NEAR(refiner.found().range_error.far_moved_share, true_share, 0.05);
  EXPECT_NEAR(refiner.found().range_error.far_from_curve_share, true_share, 0.05);
}

// A match may be surer than a point that is noisy; but for a sensor that is right that costs more
// time than it is worth.
TEST(RangeBias, StereoIsAskedBesideNoisyPointsOfASensorThatIsOff) {
  Wall wall;
  const auto stereo_seeds = [&](double error_m) {
    cv::RNG random(5);
    wall.Measure([&](const cv::Point2d&, double depth_m) {
      const double disparity = wall.rig.pair.DisparityFromDepth(depth_m);
      return wall.rig.pair.DepthFromDisparity(disparity + random.gaussian(0.5)) + error_m;
    });
    const SeedSet set =
        *Refiner{RefineConfig()}.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig));
    return std::ranges::count(set.seeds, SeedOrigin::kStereo, &Seed::origin);
  };
  EXPECT_LT(stereo_seeds(0), 1000);
  EXPECT_GT(stereo_seeds(0.04), 5000);
}

TEST(RangeBias, BelievesNoPointOfAMirroredImage) {
  Wall wall;
  cv::flip(wall.tof.depth_m, wall.tof.depth_m, 1);
  const SeedSet set = wall.Refine(RefineConfig::FIELD);
  EXPECT_TRUE(set.seeds.empty());
  EXPECT_EQ(set.contradicted, set.raw - set.outside);
}

// With the curve alone, which does not look for what else they may be.
TEST(RangeBias, SaysThatImagesContradictPointsThatItBelieves) {
  Wall wall;
  RefineConfig config;
  config.set_range_bias(RefineConfig::CURVE);
  config.set_stereo_seeds(false);
  Refiner refiner(config);
  const auto text = [&] {
    const auto set = refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig));
    EXPECT_GT(set->seeds.size(), 4000U);
    EXPECT_EQ(set->contradicted, 0);
    return DegenerateText(refiner.found(), *set, /*stereo_seeds=*/false);
  };
  EXPECT_EQ(text(), "");
  cv::flip(wall.tof.depth_m, wall.tof.depth_m, 1);
  EXPECT_THAT(text(), testing::HasSubstr("all are believed, since range_bias is not FIELD"));
}

// Its error grows from 0 to 12 px. A third of the nodes is contradicted where costs do not reach;
// further looks follow it so far that a tenth is. But who looks far enough finds a likeness
// anywhere: that way mirrored range images of fine texture seemed to fit, too.
TEST(RangeBias, RefusesASensorByTheFirstLookAlone) {
  Wall wall;
  wall.Measure([&](const cv::Point2d& at, double depth_m) {
    return wall.rig.pair.DepthFromDisparity(wall.rig.pair.DisparityFromDepth(depth_m) -
                                            12 * std::exp(-std::pow((at.x - 300) / 120, 2) / 2));
  });
  const SeedSet set = wall.Refine(RefineConfig::FIELD);
  EXPECT_TRUE(set.seeds.empty());
  EXPECT_EQ(set.contradicted, set.raw - set.outside);
}

// A camera that is covered in part, and one that is blinded, say nothing of the ranges.
TEST(RangeBias, BelievesAGoodSensorBesideABadCamera) {
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
TEST(RangeBias, BelievesASensorThatTheImagesContradictNoMoreThanEachOther) {
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

TEST(RangeBias, RefusesASensorIfStereoMatchesElsewhereInPartOfThePicture) {
  const RangeError few = WithFewMatches(350, 0.35);
  EXPECT_NEAR(few.contradicted_share, 0.35, 0.05);
  const RangeError all = WithFewMatches(0, 0.35);
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
TEST(RangeBias, MovesNoRightPointsBesideAPairWhoseColumnsAreOff) {
  RefineConfig config;
  config.set_stereo_seeds(false);
  for (const Wall& wall : {WallBeside(0.4, 1), WallBeside(0, 1.01)}) {
    Refiner refiner(config);
    const auto set = refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig));
    EXPECT_TRUE(refiner.found().range_error.ShowsNothing());
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

TEST(RangeBias, SaysHowFarStereoMayBeOffBesideSuchAPair) {
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

// A range sensor's errors are about the same in metres; a turned camera's in px.
TEST(RangeBias, SaysThatAllPointsAreOffByTheSamePx) {
  const auto same_px = [](const std::function<double(double)>& measured) {
    Wall wall;
    wall.Measure([&](const cv::Point2d&, double depth_m) { return measured(depth_m); });
    Refiner refiner{RefineConfig()};
    EXPECT_TRUE(refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig)));
    EXPECT_FALSE(refiner.found().range_error.curve_is_zero);
    return refiner.found().range_error.same_px;
  };
  const RectifiedPair pair = Wall().rig.pair;
  EXPECT_NEAR(same_px([&](double depth_m) {
                return pair.DepthFromDisparity(pair.DisparityFromDepth(depth_m) - 2);
              }),
              2, 0.2);
  EXPECT_EQ(same_px([](double depth_m) { return depth_m + 0.03; }), 0);
  EXPECT_EQ(same_px([](double depth_m) { return 1.05 * depth_m; }), 0);
}

// As where the baseline is given as a part of what it is.
TEST(RangeBias, BelievesNoPointIfRangesAreFartherOffThanASensorCanBe) {
  Wall wall;
  // At disparities of which as much is within what costs reach.
  wall.Measure(
      [&](const cv::Point2d& at, double depth_m) { return at.x < 150 ? 1.3 * depth_m : 0; });
  for (const auto bias : {RefineConfig::CURVE, RefineConfig::FIELD}) {
    RefineConfig config;
    config.set_range_bias(bias);
    Refiner refiner(config);
    const SeedSet set = *refiner.Compute(wall.left, wall.right, wall.tof, TofProjector(wall.rig));
    ASSERT_TRUE(refiner.found().range_error.absurd);
    EXPECT_NEAR(
        refiner.found().range_error.absurd->error_m / refiner.found().range_error.absurd->depth_m,
        1 - 1 / 1.3, 0.06);
    EXPECT_EQ(set.contradicted, set.raw - set.outside);
  }
}

// Of a pair that matches nearly nowhere such a curve says nothing.
TEST(RangeBias, BelievesPointsThatAreFarOffBesideAPairThatMatchesNowhere) {
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
  EXPECT_FALSE(error.Refuses());
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(kept[i].seed.disparity(), points[i].seed.disparity());
  }
}

// Texture that runs down to the right: four rows further up or down all is 16 px aside, where
// these ranges expect it. Stereo matches on its own rows.
TEST(RangeBias, BelievesThePairWhereWrongRangesFitOtherRows) {
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

TEST(RangeBias, TakesTheDataSheetsErrorWhereImagesShowNothing) {
  Wall wall(0);  // grey
  const SeedSet set = wall.Refine(RefineConfig::FIELD, 0.02);
  ASSERT_GT(set.seeds.size(), 1000U);
  const RectifiedPair& pair = wall.rig.pair;
  for (const Seed& seed : set.seeds) {
    const double depth_m = pair.DepthFromDisparity(seed.disparity());
    EXPECT_NEAR(seed.sigma_px,
                std::hypot(0.05, pair.focal_px * pair.baseline_m / (depth_m * depth_m) * 0.02),
                0.02);
  }
}

TEST(RangeBias, IsTheSameWithAnyNumberOfThreads) {
  Wall wall;
  wall.Measure([&](const cv::Point2d& at, double depth_m) {
    return Bumped(wall.rig.pair, at, depth_m) + 0.02;
  });
  const int before = cv::getNumThreads();
  cv::setNumThreads(1);
  const SeedSet one = wall.Refine(RefineConfig::FIELD);
  cv::setNumThreads(4);
  EXPECT_EQ(wall.Refine(RefineConfig::FIELD), one);
  cv::setNumThreads(before);
}

TEST(RangeBias, StandsImagesThatAreTooSmallForAWindow) {
  Wall wall;
  RefineConfig config;
  Rig rig = wall.rig;
  rig.pair.width = 6;
  rig.pair.height = 6;
  const auto set = Refiner(config).Compute(wall.left(cv::Rect(0, 0, 6, 6)).clone(),
                                           wall.right(cv::Rect(0, 0, 6, 6)).clone(), wall.tof,
                                           TofProjector(rig));
  EXPECT_TRUE(set.has_value());
}

}  // namespace
}  // namespace sprout::refine
