#include "services/refine/refiner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/services/refine/refine_scene.h"

namespace sprout::refine {
namespace {

using testing::HasSubstr;

RefineConfig PaperAnd(const std::string& more) { return With(more, PaperRules()); }

// Where the images, of one colour, say nothing.
const std::string kHiding = "hidden_reach: 0.8 hidden_core: 0.8";

TEST(Refiner, ProjectsEveryReturnIntoBothImages) {
  Scene scene;
  scene.SetDisparity(3, 2, 8);
  scene.SetDisparity(7, 5, 20);
  const auto result = scene.Refine();
  ASSERT_EQ(result->seeds.size(), 2u);
  EXPECT_EQ(result->raw, 2);
  EXPECT_NEAR(result->seeds[0].u, 30, 1e-4);
  EXPECT_NEAR(result->seeds[0].v, 20, 1e-4);
  EXPECT_NEAR(result->seeds[0].u_right, 22, 1e-4);
  EXPECT_NEAR(result->seeds[1].disparity(), 20, 1e-4);
  EXPECT_EQ(CountTofSeeds(result->seeds), 2);
  EXPECT_EQ(cv::Point(result->seeds[0].tof_u, result->seeds[0].tof_v), cv::Point(3, 2));
  EXPECT_EQ(cv::Point(result->seeds[1].tof_u, result->seeds[1].tof_v), cv::Point(7, 5));
}

TEST(Refiner, DropsPointsWhoseWindowLeavesEitherImage) {
  Scene scene;
  scene.SetDisparity(0, 4, 1);   // u = 0: left
  scene.SetDisparity(4, 0, 1);   // v = 0: above
  scene.SetDisparity(1, 4, 9);   // u' = 1: right image
  scene.SetDisparity(1, 5, 8);   // u' = 2: just inside
  scene.SetDisparity(5, 5, -1);  // nearer than infinity, but d < 0
  const auto result = scene.Refine();
  EXPECT_EQ(result->seeds.size(), 1u);
  EXPECT_EQ(result->outside, 4);
  EXPECT_EQ(result->raw, 5);
}

TEST(Refiner, CountsPointsBehindTheCamerasAsOutside) {
  Scene scene;
  scene.rig.tof.left_from_tof_translation_m.z() = -1;
  scene.tof.depth_m(4, 5) = 0.5f;
  scene.tof.depth_m(4, 6) = 3.0f;
  const auto result = scene.Refine();
  EXPECT_EQ(result->raw, 2);
  EXPECT_EQ(result->outside, 1);
  EXPECT_EQ(result->seeds.size(), 1u);
}

TEST(Refiner, DropsSeedsOnDarkRegionsOfTheLeftImage) {
  Scene scene;
  scene.SetDisparity(3, 2, 8);
  scene.SetDisparity(6, 2, 8);
  scene.left(cv::Rect(58, 18, 5, 5)) = 7;   // mean of the window around (60, 20): 7
  scene.right(cv::Rect(20, 18, 5, 5)) = 0;  // the right image does not count
  const auto result = scene.Refine(PaperAnd("min_mean_grey: 8"));
  EXPECT_EQ(result->dark, 1);
  ASSERT_EQ(result->seeds.size(), 1u);
  EXPECT_NEAR(result->seeds[0].u, 30, 1e-4);
  EXPECT_EQ(scene.Refine(PaperAnd("min_mean_grey: 7"))->dark, 0);
}

TEST(Refiner, DropsSeedsWithAWeakAmplitude) {
  Scene scene;
  scene.SetDisparity(3, 2, 8);
  scene.SetDisparity(6, 2, 8);
  scene.SetDisparity(6, 4, 8);
  scene.tof.amplitude = cv::Mat1f(8, 10, 50.f);
  scene.tof.amplitude(2, 6) = 19;
  scene.tof.amplitude(4, 6) = kNoReturn;
  const RefineConfig config = PaperAnd("min_amplitude: 20");
  EXPECT_EQ(scene.Refine(config)->dark, 2);
  scene.tof.amplitude = cv::Mat1f();
  EXPECT_EQ(scene.Refine(config)->dark, 0);
}

using Flags = std::vector<uint8_t>;

Flags FindBackground(const std::vector<Seed>& seeds, double tolerance_px) {
  return BackgroundRule().Find(seeds, {100, 80}, tolerance_px);
}

TEST(Refiner, FindsBackgroundBesideANearerSeedInTheLeftImage) {
  const std::vector<Seed> seeds = {{20, 20, 10}, {22, 21, 17}, {40, 20, 35}, {45, 20, 40}};
  EXPECT_EQ(FindBackground(seeds, 1), (Flags{0, 1, 0, 0}));
}

TEST(Refiner, FindsBackgroundThatFallsOntoANearerSeedInTheRightImage) {
  // Apart in the left image, on one pixel in the right one: the right camera sees the nearer.
  const std::vector<Seed> seeds = {{50, 20, 30}, {40, 21, 31}};
  EXPECT_EQ(FindBackground(seeds, 1), (Flags{0, 1}));
}

TEST(Refiner, ToleratesSlantsAndLooksTwoPixelsFar) {
  const std::vector<Seed> within = {{20, 20, 10}, {22, 22, 13}};  // d = 10 and 9
  EXPECT_EQ(FindBackground(within, 1), (Flags{0, 0}));
  EXPECT_EQ(FindBackground(within, 0.5), (Flags{0, 1}));
  const std::vector<Seed> apart = {{20, 20, 10}, {23, 20, 20}};
  EXPECT_EQ(FindBackground(apart, 1), (Flags{0, 0}));
}

TEST(Refiner, ComparesAllSeedsInAWindowWithEachOther) {
  // The outer two are 4 px apart, but both lie in the window of the middle one.
  const std::vector<Seed> seeds = {{20, 20, 10}, {22, 20, 12.5f}, {24, 20, 16}};  // d = 10, 9.5, 8
  EXPECT_EQ(FindBackground(seeds, 1), (Flags{0, 0, 1}));
}

TEST(Refiner, DoesNotDependOnTheOrderOfTheSeeds) {
  const std::vector<Seed> seeds = {{22, 21, 17}, {20, 20, 10}};
  EXPECT_EQ(FindBackground(seeds, 1), (Flags{1, 0}));
}

TEST(Refiner, CountsAddUp) {
  Scene scene;
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 10; ++i) scene.SetDisparity(i, j, 3 + i);
  }
  scene.left(cv::Rect(40, 0, 30, 80)) = 0;
  const auto result = scene.Refine(PaperAnd("min_mean_grey: 8"));
  EXPECT_EQ(result->raw, 80);
  EXPECT_GT(result->dark, 0);
  EXPECT_GT(result->outside, 0);
  EXPECT_EQ(
      static_cast<int>(result->seeds.size()) + result->dark + result->outside + result->background,
      result->raw);
}

// A wall of 4 px behind a board of 16 px in ToF columns 4 to 6, as the ToF camera of MakeRig()
// sees them; it stands `tof_x_m` to the right of the left camera.
Scene BoardBeforeWall(double tof_x_m) {
  Scene scene;
  scene.rig.tof.left_from_tof_translation_m.x() = tof_x_m;
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 10; ++i) scene.SetDisparity(i, j, i >= 4 && i <= 6 ? 16 : 4);
  }
  return scene;
}

TEST(Refiner, DropsPointsThatANearerSurfaceHidesAndCountsThem) {
  const Scene scene = BoardBeforeWall(0.05);
  // The board's edge and the wall's next point lie 4 px apart: too far for a window of 5×5 px.
  EXPECT_EQ(scene.Refine()->background, 0);
  EXPECT_EQ(scene.Refine()->hidden, 0);
  const auto refined = scene.Refine(PaperAnd(kHiding));
  EXPECT_EQ(refined->hidden, 14);  // a point at either edge in seven rows
  EXPECT_EQ(static_cast<int>(refined->seeds.size()) + refined->outside + refined->background +
                refined->hidden,
            refined->raw);
  for (const Seed& seed : refined->seeds) {
    if (seed.disparity() > 10) continue;
    for (const Seed& other : refined->seeds) {
      const bool on_board = other.disparity() > 10 && std::abs(other.v - seed.v) < 1;
      EXPECT_FALSE(on_board && std::abs(other.u - seed.u) < 7);
      EXPECT_FALSE(on_board && std::abs(other.u_right - seed.u_right) < 7);
    }
  }
}

// Seeds that only the left camera sees.
SeedSet LeftSeeds(const Scene& scene, const RefineConfig& config) {
  Refiner refiner(config);
  EXPECT_TRUE(refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig)));
  return refiner.left_seeds();
}

TEST(Refiner, KeepsWhatLiesOutsideTheRightImageForThePrior) {
  Scene scene;
  scene.SetDisparity(1, 4, 9);    // u' = 1: its window leaves the right image
  scene.SetDisparity(2, 4, 60);   // u' = −40: far outside
  scene.SetDisparity(3, 4, 60);   // the same, on a dark region
  scene.SetDisparity(0, 4, 1);    // its window leaves the left image
  scene.SetDisparity(6, 4, 120);  // no two images of this width show that
  scene.SetDisparity(7, 4, 8);    // seen by both
  scene.left(cv::Rect(28, 38, 5, 5)) = 0;
  const RefineConfig config = PaperAnd("min_mean_grey: 8");
  const SeedSet left_seeds = LeftSeeds(scene, config);
  EXPECT_EQ(left_seeds.raw, 3);
  EXPECT_EQ(left_seeds.dark, 1);
  ASSERT_EQ(left_seeds.seeds.size(), 2u);
  EXPECT_NEAR(left_seeds.seeds[0].disparity(), 9, 1e-3);
  EXPECT_NEAR(left_seeds.seeds[1].u_right, -40, 1e-3);
  const auto seeds = scene.Refine(config);
  EXPECT_EQ(seeds->outside, 5);
  EXPECT_EQ(seeds->dark, 0);
  EXPECT_EQ(seeds->seeds.size(), 1u);
}

TEST(Refiner, KeepsWhatOnlyTheRightCameraDoesNotSeeForThePrior) {
  const Scene scene = BoardBeforeWall(0.05);
  const RefineConfig config = PaperAnd(kHiding);
  const SeedSet left_seeds = LeftSeeds(scene, config);
  // The wall's point left of the board in seven rows, the one to its right is hidden from the left;
  // and at the left border what lies outside the right image.
  const auto count_between = [&](float from, float to) {
    return std::count_if(left_seeds.seeds.begin(), left_seeds.seeds.end(), [&](const Seed& seed) {
      return seed.u >= from && seed.u < to && seed.disparity() < 10;
    });
  };
  EXPECT_EQ(count_between(0, 15), 7);
  EXPECT_EQ(count_between(15, 40), 7);
  EXPECT_EQ(count_between(40, 100), 0);
  EXPECT_EQ(left_seeds.raw, static_cast<int>(left_seeds.seeds.size()) + left_seeds.hidden);
  EXPECT_TRUE(LeftSeeds(Scene(), config).seeds.empty());
}

TEST(Refiner, DropsLoosePointsBeforeTheyCanHideOthers) {
  Scene scene = BoardBeforeWall(0);
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 10; ++i) scene.SetDisparity(i, j, 4);
  }
  scene.SetDisparity(5, 4, 30);  // alone before the wall
  EXPECT_GT(scene.Refine(PaperAnd(kHiding))->hidden, 0);
  const auto result = scene.Refine(PaperAnd(kHiding + " loose_tolerance_px: 2"));
  EXPECT_EQ(result->loose, 1);
  EXPECT_EQ(result->hidden, 0);
}

TEST(Refiner, SaysWhatIsWrongWithSizes) {
  Scene scene;
  scene.right = cv::Mat1b(80, 99, uint8_t{0});
  EXPECT_THAT(scene.Refine().error().text, HasSubstr("99x80"));
}

TEST(Refiner, RefusesAToleranceOutOfRange) {
  EXPECT_THROW(Refiner{With<RefineConfig>("background_tolerance_px: -1")}, ConfigError);
}

TEST(Refiner, TakesSeedsFromThePairWhereThereIsNoReturn) {
  Scene scene = TexturedScene();
  const auto blind = scene.Refine(RefineConfig());
  ASSERT_GT(blind->seeds.size(), 50U);
  EXPECT_EQ(blind->raw, 0);
  for (const Seed& seed : blind->seeds) {
    EXPECT_EQ(seed.origin, SeedOrigin::kStereo);
    EXPECT_NEAR(seed.disparity(), 12, 0.5);
  }
  scene.tof = {};
  scene.rig.tof = {};  // nothing at all
  EXPECT_EQ(*scene.Refine(RefineConfig()), *blind);
  EXPECT_TRUE(scene.Refine(With<RefineConfig>("stereo_seeds: false"))->seeds.empty());
}

TEST(Refiner, BelievesNoPointOfASensorThatGivesNoise) {
  Scene scene = TexturedScene();
  const auto blind = scene.Refine(RefineConfig());
  cv::RNG random(1);
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 10; ++i) scene.SetDisparity(i, j, random.uniform(2.0, 25.0));
  }
  Refiner refiner(With<RefineConfig>("range_bias: OFF"));  // which may contradict them before
  const auto seeds = refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig));
  EXPECT_TRUE(refiner.found().are_noise);
  EXPECT_GT(seeds->loose, 30);
  EXPECT_TRUE(refiner.left_seeds().seeds.empty());
  EXPECT_EQ(seeds->seeds, blind->seeds);
  // Half a wall and half noise is a sensor that sees something.
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 7; ++i) scene.SetDisparity(i, j, 12);
  }
  refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig));
  EXPECT_FALSE(refiner.found().are_noise);
}

TEST(Refiner, BelievesNoPointOfADisplacedSensor) {
  BoxScene scene(25);
  Refiner refiner{RefineConfig()};
  const auto seeds = refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig));
  const SensorPlace& place = refiner.found().sensor_place;
  EXPECT_TRUE(place.is_displaced);
  EXPECT_NEAR(place.move_px.x, -25, 8);
  EXPECT_NEAR(place.move_px.y, 0, 8);
  EXPECT_EQ(seeds->contradicted, seeds->raw - seeds->outside);
  EXPECT_TRUE(refiner.left_seeds().seeds.empty());
  scene.tof = {};
  scene.rig.tof = {};
  EXPECT_EQ(seeds->seeds, scene.Refine(RefineConfig())->seeds);
  // The next frame is judged by itself.
  const BoxScene right;
  ASSERT_TRUE(refiner.Compute(right.left, right.right, right.tof, TofProjector(right.rig)));
  EXPECT_FALSE(refiner.found().sensor_place.is_displaced);
  EXPECT_FALSE(refiner.found().range_error.rejected);
}

TEST(Refiner, BelievesNoPointOfASensorWithAnotherLens) {
  BoxScene scene(0, 1.25);
  Refiner refiner{RefineConfig()};
  ASSERT_TRUE(refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig)));
  EXPECT_TRUE(refiner.found().sensor_place.is_displaced);
  EXPECT_NEAR(refiner.found().sensor_place.spread, 1.25, 0.04);
  EXPECT_TRUE(refiner.left_seeds().seeds.empty());
}

// So near that the right camera would not see it, the images cannot be compared there.
TEST(Refiner, BelievesNoRangesThatWrap) {
  BoxScene scene;
  for (int j = 30; j < 60; ++j) {
    for (int i = 12; i < 40; ++i) scene.SetDisparity(i, j, 250);
  }
  Refiner refiner{RefineConfig()};
  const auto seeds = refiner.Compute(scene.left, scene.right, scene.tof, TofProjector(scene.rig));
  EXPECT_NEAR(refiner.found().contradiction.share, 28 * 30 / 4800.0, 0.05);
  EXPECT_GT(CountTofSeeds(seeds->seeds), 3000);
  for (const SeedSet* set : {&*seeds, &refiner.left_seeds()}) {
    for (const Seed& seed : set->seeds) ASSERT_LT(seed.disparity(), 22) << seed.u << " " << seed.v;
  }
}

TEST(Refiner, PutsSeedsOfThePairBehindThoseOfTheTofCamera) {
  Scene scene = TexturedScene();
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 5; ++i) scene.SetDisparity(i, j, 12);
  }
  // 40 points are too few to show how far they are off.
  const auto both = scene.Refine(With<RefineConfig>("range_error_m: 0.001"));
  const auto first_of_stereo =
      std::find_if(both->seeds.begin(), both->seeds.end(),
                   [](const Seed& seed) { return seed.origin == SeedOrigin::kStereo; });
  ASSERT_NE(first_of_stereo, both->seeds.begin());
  ASSERT_NE(first_of_stereo, both->seeds.end());
  EXPECT_EQ(first_of_stereo - both->seeds.begin(), CountTofSeeds(both->seeds));
  for (auto seed = first_of_stereo; seed != both->seeds.end(); ++seed) {
    // The points that the right camera sees, too, are those from column 20 on; they end at (40,
    // 70).
    EXPECT_TRUE(seed->u < 20 || seed->u > 40 || seed->v < 10 || seed->v > 70)
        << seed->u << ", " << seed->v;
  }
}

TEST(Refiner, KnowsThatNoiseInMetresGrowsWithTheDisparity) {
  BoxScene scene;
  const cv::Size size = scene.tof.depth_m.size();
  for (int j = 0; j < size.height; ++j) {
    for (int i = 0; i < size.width; ++i) scene.SetDisparity(i, j, 5 + i / 2.0);
  }
  const double noise_m = 0.004 * scene.tof.depth_m(0, 0);
  cv::RNG random(4);
  for (float& depth_m : scene.tof.depth_m) {
    depth_m += static_cast<float>(random.gaussian(noise_m));
  }
  // The images show something else.
  const auto seeds = scene.Refine(With<RefineConfig>("range_bias: OFF"));
  const auto sigma_px = [&](float disparity) {
    for (const Seed& seed : seeds->seeds) {
      if (std::abs(seed.disparity() - disparity) < 0.1F) return seed.sigma_px;
    }
    return 0.0F;
  };
  // Of 0.004 (5 / d) z: 0.004 d² / 5.
  EXPECT_NEAR(sigma_px(15), 0.18, 0.04);
  EXPECT_NEAR(sigma_px(30), 0.72, 0.1);
}

// Stereo by itself looks for disparities of up to a fifth of the width, 20 px.
TEST(Refiner, SearchesStereoAsFarAsPointsAreNear) {
  Scene scene = TexturedScene();
  scene.left.colRange(30, 100).copyTo(scene.right.colRange(0, 70));
  for (int j = 0; j < 4; ++j) {  // the lower half has no return
    for (int i = 0; i < 10; ++i) scene.SetDisparity(i, j, 30);
  }
  const Result<SeedSet> seeds = scene.Refine(RefineConfig());
  ASSERT_TRUE(seeds);
  const auto is_near_match = [](const Seed& seed) {
    return seed.origin == SeedOrigin::kStereo && std::abs(seed.disparity() - 30) < 1;
  };
  EXPECT_GT(std::ranges::count_if(seeds->seeds, is_near_match), 20);
  const Result<SeedSet> as_asked = scene.Refine(With<RefineConfig>("stereo_max_disparity_px: 20"));
  ASSERT_TRUE(as_asked);
  EXPECT_EQ(std::ranges::count_if(as_asked->seeds, is_near_match), 0);
}

}  // namespace
}  // namespace sprout::refine
