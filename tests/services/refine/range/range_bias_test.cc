#include "services/refine/range/range_bias.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

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

// Borders of JPEG's blocks lie on the same columns in both images, as if a plain wall's disparity
// were a multiple of 8 px.
TEST(RangeBias, LeavesARightSensorAloneBesidePlainWallsInJpeg) {
  Wall wall;
  const cv::Mat1b texture = wall.left.rowRange(250, kWallSize.height).clone();
  for (int v = 0; v < kWallSize.height; ++v) {
    for (int u = 0; u < kWallSize.width; ++u) {
      wall.left(v, u) = cv::saturate_cast<uint8_t>(150 + 30 * std::sin(u / 60.0) + 0.1 * v);
    }
  }
  texture.copyTo(wall.left.rowRange(250, kWallSize.height));
  wall.ShowOnTheRight();
  for (cv::Mat1b* image : {&wall.left, &wall.right}) {
    std::vector<uchar> bytes;
    cv::imencode(".jpg", *image, bytes, {cv::IMWRITE_JPEG_QUALITY, 50});
    *image = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  }
  EXPECT_GT(ShareWithin(wall.Refine(RefineConfig::FIELD), 0.25), 0.99);
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
