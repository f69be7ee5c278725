#include "services/refine/unwrapping/range_unwrapper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/services/refine/refine_scene.h"

namespace sprout::refine {
namespace {

constexpr double kDisparity = 12;  // of the wall that the images show, px
constexpr int kPoints = 80;        // of the ToF image

RefineConfig WithRange(double range_m) {
  RefineConfig config = PaperRules();
  config.set_unambiguous_range_m(range_m);
  return config;
}

double RangePerDepth(const Scene& scene, int i, int j) {
  return TofProjector(scene.rig).ray(i, j).norm();
}

double WallDepthM(const Scene& scene) { return scene.rig.pair.DepthFromDisparity(kDisparity); }

// The wall as a camera sees it whose unambiguous range ends before it.
void SetWrappedWall(double range_m, Scene& scene) {
  for (int j = 0; j < scene.tof.depth_m.rows; ++j) {
    for (int i = 0; i < scene.tof.depth_m.cols; ++i) {
      const double per_depth = RangePerDepth(scene, i, j);
      scene.tof.depth_m(j, i) = static_cast<float>(WallDepthM(scene) - range_m / per_depth);
    }
  }
}

// Seeds where the wall is.
int64_t OnWall(const SeedSet& result) {
  return std::ranges::count_if(result.seeds, [](const Seed& seed) {
    return std::abs(seed.disparity() - kDisparity) < 0.01;
  });
}

int Dropped(const SeedSet& result) {
  return result.outside + result.dark + result.loose + result.background + result.hidden +
         result.contradicted;
}

TEST(RangeUnwrapper, MovesASurfaceBeyondTheRangeToWhereTheImagesMatch) {
  Scene scene = TexturedScene();
  const double range_m = 0.6 * WallDepthM(scene);
  SetWrappedWall(range_m, scene);
  EXPECT_EQ(OnWall(*scene.Refine()), 0);
  const auto result = scene.Refine(WithRange(range_m));
  EXPECT_GT(OnWall(*result), 45);  // all that lie in both images
  EXPECT_EQ(OnWall(*result), std::ssize(result->seeds));
  EXPECT_EQ(result->raw, kPoints);
  EXPECT_EQ(Dropped(*result) + std::ssize(result->seeds), kPoints);
  EXPECT_EQ(cv::Point(result->seeds[0].tof_u, result->seeds[0].tof_v) * 10,
            cv::Point(cvRound(result->seeds[0].u), cvRound(result->seeds[0].v)));
}

TEST(RangeUnwrapper, GivesTheRangeImageAsItShouldBe) {
  Scene scene = TexturedScene();
  const double range_m = 0.6 * WallDepthM(scene);
  SetWrappedWall(range_m, scene);
  scene.tof.depth_m(3, 4) = kNoReturn;
  const TofImage tof =
      RangeUnwrapper().Unwrap(scene.left, scene.right, scene.tof, TofProjector(scene.rig), range_m);
  EXPECT_TRUE(std::isnan(tof.depth_m(3, 4)));
  EXPECT_NEAR(tof.depth_m(0, 0), WallDepthM(scene), 1e-5);
  EXPECT_NEAR(tof.depth_m(7, 9), WallDepthM(scene), 1e-5);
}

TEST(RangeUnwrapper, LeavesASurfaceThatIsWhereItSays) {
  Scene scene = TexturedScene();
  SetWrappedWall(0, scene);
  const SeedSet without = *scene.Refine();
  EXPECT_GT(OnWall(without), 45);
  for (const double share : {0.4, 1.2, 3.0}) {
    EXPECT_EQ(*scene.Refine(WithRange(share * WallDepthM(scene))), without) << share;
  }
}

TEST(RangeUnwrapper, LeavesAFewPointsAlone) {
  for (const int rows : {2, 4}) {  // of 10 points each
    Scene scene = TexturedScene();
    const double range_m = 0.6 * WallDepthM(scene);
    SetWrappedWall(range_m, scene);
    scene.tof.depth_m.rowRange(rows, 8) = kNoReturn;
    const bool enough = 10 * rows >= UnwrappingRules::kMinPoints;
    EXPECT_EQ(OnWall(*scene.Refine(WithRange(range_m))) > 0, enough) << rows;
  }
}

// A wall without texture, of which all of the left half is beyond the range.
Scene PlainScene(double near_m, double far_m, double range_m) {
  Scene scene;
  scene.tof.amplitude.create(scene.tof.depth_m.size());
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 10; ++i) {
      const double true_m = i < 5 ? far_m : near_m;
      const double measured_m = true_m > range_m ? true_m - range_m : true_m;
      scene.tof.depth_m(j, i) = static_cast<float>(measured_m / RangePerDepth(scene, i, j));
      scene.tof.amplitude(j, i) = static_cast<float>(100 / (true_m * true_m));
    }
  }
  return scene;
}

// Seeds as far along the ToF camera's rays.
int64_t AtRange(const Scene& scene, const SeedSet& result, double range_m) {
  return std::ranges::count_if(result.seeds, [&](const Seed& seed) {
    return std::abs(PointFromSeed(scene.rig.pair, seed).norm() - range_m) < 0.01;
  });
}

TEST(RangeUnwrapper, GoesByTheAmplitudeWhereThereIsNoTexture) {
  Scene scene = PlainScene(0.7, 1.1, 1);
  const SeedSet result = *scene.Refine(WithRange(1));
  EXPECT_GT(AtRange(scene, result, 1.1), 20);
  EXPECT_GT(AtRange(scene, result, 0.7), 20);
  scene.tof.amplitude = {};
  EXPECT_EQ(AtRange(scene, *scene.Refine(WithRange(1)), 1.1), 0);
}

TEST(RangeUnwrapper, TakesNoSurfaceForFarThatIsMerelyDark) {
  Scene scene = PlainScene(0.7, 0.5, 1);  // nothing is beyond
  const SeedSet without = *scene.Refine();
  scene.tof.amplitude.colRange(0, 5) *= 0.1;
  EXPECT_EQ(*scene.Refine(WithRange(1)), without);
}

TEST(RangeUnwrapper, TakesNoHarmFromAmplitudesThatAreNone) {
  Scene scene = PlainScene(0.7, 0.5, 1);
  for (const float none : {kNoReturn, std::numeric_limits<float>::infinity(), -1.0F, 0.0F}) {
    scene.tof.amplitude = none;
    EXPECT_EQ(*scene.Refine(WithRange(1)), *scene.Refine()) << none;
  }
}

TEST(RangeUnwrapper, DropsASurfaceOnWhichTheImagesAreUnclear) {
  // Texture around few of the points: these match one range farther, and of the others nothing is
  // known.
  Scene scene;
  const Scene textured = TexturedScene();
  const cv::Rect patch(35, 35, 31, 21);
  const cv::Rect in_right = patch - cv::Point(cvRound(kDisparity), 0);
  textured.left(patch).copyTo(scene.left(patch));
  textured.left(patch).copyTo(scene.right(in_right));
  const double range_m = 0.6 * WallDepthM(scene);
  SetWrappedWall(range_m, scene);
  const SeedSet result = *scene.Refine(WithRange(range_m));
  EXPECT_EQ(result.contradicted, kPoints);
  EXPECT_EQ(result.raw, kPoints);
  EXPECT_TRUE(result.seeds.empty());
}

}  // namespace
}  // namespace sprout::refine
