#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "services/tools/evaluate/evaluate.h"
#include "tests/services/tools/evaluate/small_scene.h"

namespace sprout::evaluate {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// Disparity 10 everywhere; (50, 40) is hidden from the right camera, (60, 40) unknown, (70, 40) in
// neither mask.
Scene KnownScene() {
  Scene scene = SmallScene();
  scene.frame.truth.left = 10.F;
  scene.frame.truth.left(40, 60) = kUnknown;
  scene.nonoccluded = 255;
  scene.occluded = 0;
  scene.occluded(40, 50) = 255;
  for (int u : {50, 60, 70}) scene.nonoccluded(40, u) = 0;
  return scene;
}

Seed SeedAt(float u, float v, float disparity) {
  return {.u = u, .v = v, .u_right = u - disparity};
}

SeedCounts Count(const Seed& seed) { return CountSeeds({&seed, 1}, KnownScene()); }

TEST(SeedQuality, CallsASeedGoodUpToThreePixelsFromTheTruth) {
  EXPECT_EQ(Count(SeedAt(30, 30, 13)).good, 1);
  EXPECT_EQ(Count(SeedAt(30, 30, 13)).wrong, 0);
  EXPECT_EQ(Count(SeedAt(30, 30, 13.125F)).good, 0);
  EXPECT_EQ(Count(SeedAt(30, 30, 13.125F)).wrong, 1);
  EXPECT_EQ(Count(SeedAt(30, 30, 6.875F)).wrong, 1);
}

TEST(SeedQuality, CallsASeedWrongOnAHiddenPixelWhateverItsDisparity) {
  EXPECT_EQ(Count(SeedAt(50, 40, 10)).wrong, 1);
  EXPECT_EQ(Count(SeedAt(50.4F, 39.6F, 10)).wrong, 1) << "the nearest pixel counts";
  EXPECT_EQ(Count(SeedAt(50.6F, 40, 10)).good, 1);
}

TEST(SeedQuality, LeavesOutWhatItCannotJudge) {
  for (const Seed& seed : {SeedAt(60, 40, 10), SeedAt(70, 40, 10), SeedAt(-0.6F, 5, 10),
                           SeedAt(5, 71.6F, 10), SeedAt(1e20F, 5, 10), SeedAt(kUnknown, 5, 10)}) {
    EXPECT_EQ(Count(seed).good, 0) << seed.u;
    EXPECT_EQ(Count(seed).wrong, 0) << seed.u;
  }
}

TEST(SeedQuality, SharesAreOfAllPointsBeforeAndOfKeptOnesAfter) {
  RefinementQuality quality;
  quality.refined.raw = 200;
  quality.refined.seeds.resize(160);
  quality.before = {.good = 150, .wrong = 40};
  quality.after = {.good = 144, .wrong = 8};
  EXPECT_DOUBLE_EQ(quality.wrong_before_percent(), 20);
  EXPECT_DOUBLE_EQ(quality.wrong_after_percent(), 5);
  quality.good_lost = 9;
  EXPECT_DOUBLE_EQ(quality.good_lost_percent(), 6);
  EXPECT_TRUE(std::isnan(RefinementQuality().wrong_before_percent()));
}

TEST(SeedQuality, CountsAGoodPointAsLostWhenNoSeedOfItsTofPixelIsKept) {
  const auto point = [](float u, float disparity, int16_t tof_u) {
    Seed seed = SeedAt(u, 30, disparity);
    seed.tof_u = tof_u;
    seed.tof_v = 3;
    return seed;
  };
  const std::vector<Seed> points = {point(20, 10, 2), point(30, 11, 3), point(40, 9, 4),
                                    point(50, 20, 5), point(50, 10, 6)};
  // Kept as it was, moved away, dropped; the wrong ones and those from stereo do not count.
  std::vector<Seed> kept = {point(20, 10, 2), point(30, 30, 3), point(50, 10, 6)};
  EXPECT_EQ(CountGoodLost(points, kept, KnownScene()), 1);
  for (float u = 20; u < 60; ++u) {
    kept.push_back(SeedAt(u, 31, 10));
    kept.back().origin = SeedOrigin::kStereo;
  }
  EXPECT_EQ(CountGoodLost(points, kept, KnownScene()), 1);
  EXPECT_EQ(CountGoodLost(points, {}, KnownScene()), 4) << "(50, 30) is seen by both cameras";
  EXPECT_EQ(CountGoodLost(points, points, KnownScene()), 0);
}

TEST(SeedQuality, LosesNoFewerGoodPointsWhereStereoAddsSeeds) {
  const Scene scene = LoadScene("synthetic:320x240", TofChoice("grid:16"), {});
  RefineConfig of_tof;
  of_tof.set_stereo_seeds(false);
  const RefinementQuality with_stereo = JudgeRefinement(scene, {});
  EXPECT_GT(with_stereo.after.good, with_stereo.before.good);
  EXPECT_GT(with_stereo.good_lost, 0);
  EXPECT_EQ(with_stereo.good_lost, JudgeRefinement(scene, of_tof).good_lost);
}

TEST(SeedQuality, SeesThatRefinementDropsHiddenBackground) {
  const Scene scene = LoadScene("synthetic:320x240", TofChoice("grid:3"), {});
  const RefinementQuality quality = JudgeRefinement(scene, {});
  EXPECT_EQ(quality.refined.raw, quality.refined.outside + quality.refined.dark +
                                     quality.refined.loose + quality.refined.background +
                                     quality.refined.hidden + quality.refined.contradicted +
                                     CountTofSeeds(quality.refined.seeds));
  EXPECT_GT(quality.before.wrong, 0);
  EXPECT_LT(quality.after.wrong, quality.before.wrong);
  // 3.6 % if those that only the left camera sees were lost.
  EXPECT_LT(quality.good_lost_percent(), 3);
}

}  // namespace
}  // namespace sprout::evaluate
