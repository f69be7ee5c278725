#include "common/scenes/synthetic_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sprout::scenes {
namespace {

constexpr double kFocalPx = 500;

Solid Box(Vec3 centre, Vec3 half_size) {
  Solid box;
  box.centre = centre;
  box.half_size = half_size;
  box.material = {.dark_bgr = {0, 0, 0}, .light_bgr = {255, 255, 255}, .textured = true, .key = 5};
  return box;
}

TEST(SyntheticScene, MeetsSolidsWhereGeometrySays) {
  const Ray ahead{{0.1, 0, 0}, {0, 0, 1}};
  Solid solid = Box({0, 0, 4}, {0.5, 0.5, 1});
  EXPECT_DOUBLE_EQ(Intersect(solid, ahead), 3);
  solid.cos_yaw = 0;  // a quarter turn: now 1 m wide to either side and 0.5 m deep
  solid.sin_yaw = 1;
  EXPECT_DOUBLE_EQ(Intersect(solid, ahead), 3.5);
  EXPECT_DOUBLE_EQ(Intersect(solid, {{0.9, 0, 0}, {0, 0, 1}}), 3.5);
  EXPECT_EQ(Intersect(solid, {{1.1, 0, 0}, {0, 0, 1}}), INFINITY);
  solid.cos_yaw = 0.8;  // right-handed: the middle of its front face is at (−0.6, 0, −0.8)
  solid.sin_yaw = 0.6;
  EXPECT_DOUBLE_EQ(Intersect(solid, {{-0.6, 0, 0}, {0, 0, 1}}), 4 - 0.8);

  solid = Box({0, 0, 4}, {0.5, 0.5, 0.5});
  solid.shape = Solid::Shape::kSphere;
  EXPECT_DOUBLE_EQ(Intersect(solid, {{0.3, 0, 0}, {0, 0, 1}}), 4 - 0.4);
  EXPECT_EQ(Intersect(solid, {{0.6, 0, 0}, {0, 0, 1}}), INFINITY);
  solid.centre.z = -4;  // behind the camera
  EXPECT_EQ(Intersect(solid, ahead), INFINITY);

  solid = Box({0, 2, 0}, {});
  solid.shape = Solid::Shape::kFloor;
  EXPECT_DOUBLE_EQ(Intersect(solid, {{0, 0, 0}, {0, 0.5, 1}}), 4);
  EXPECT_EQ(Intersect(solid, {{0, 0, 0}, {0, -0.5, 1}}), INFINITY);
}

TEST(SyntheticScene, TexturesTurnAndMoveWithTheirObjects) {
  // Half a turn takes a point of the top face to its mirror image: as far away, under the same
  // slant and light.
  Solid before = Box({0, 1, 4}, {0.5, 0.5, 0.5});
  Solid after = before;
  after.cos_yaw = -1;
  int changed_in_place = 0;
  for (double x = 0.05; x < 0.45; x += 0.02) {
    const Vec3 colour = ColourAt(before, {x, 0.5, 4}, kFocalPx);
    EXPECT_NEAR(ColourAt(after, {-x, 0.5, 4}, kFocalPx).x, colour.x, 1e-6);
    if (std::abs(ColourAt(after, {x, 0.5, 4}, kFocalPx).x - colour.x) > 5) ++changed_in_place;
  }
  EXPECT_GT(changed_in_place, 5);
}

TEST(SyntheticScene, FeaturesAreAFewPixelsWideAtEveryDistance) {
  for (double z : {1.0, 2.5, 6.0}) {
    const Solid wall = Box({0, 0, z + 0.5}, {9, 9, 0.5});
    double next_pixel = 0;
    double far_pixel = 0;
    for (int u = 0; u < 400; ++u) {
      const auto grey = [&](double column) {
        return ColourAt(wall, {(column - 200) * z / kFocalPx, 0.3, z}, kFocalPx).x;
      };
      next_pixel += std::abs(grey(u + 0.5) - grey(u)) / 400;
      far_pixel += std::abs(grey(u + 20) - grey(u)) / 400;
    }
    EXPECT_GT(far_pixel, 20) << z;               // contrast
    EXPECT_LT(next_pixel, far_pixel / 3) << z;   // no finer than a view can show
    EXPECT_GT(next_pixel, far_pixel / 30) << z;  // and not blurred either
  }
}

// Checks the shortcuts of the renderer against all solids at every pixel.
TEST(SyntheticScene, IsRenderedWithTheNearestSolidInBothViews) {
  for (uint32_t seed = 0; seed < 6; ++seed) {
    CaptureConfig config;
    config.set_source("synthetic:160x120");
    config.set_seed(seed);
    const auto source = OpenDataset(config);
    const RectifiedPair& pair = source->rig().pair;
    // The bottom row sees the floor at 1.6 m.
    const SyntheticScene scene(seed, 1.6 * pair.height / (2 * pair.focal_px));
    for (int64_t index : {0, 45}) {
      const std::vector<Solid> solids = scene.At(index);
      const GroundTruth truth = source->Get(index).truth;
      const auto expected = [&](int u, int v, double cx, double eye_x_m) {
        const Ray ray{{eye_x_m, 0, 0},
                      {(u - cx) / pair.focal_px, (v - pair.cy) / pair.focal_px, 1}};
        double depth_m = INFINITY;
        for (const Solid& solid : solids) depth_m = std::min(depth_m, Intersect(solid, ray));
        return pair.DisparityFromDepth(depth_m);
      };
      for (int v = 0; v < pair.height; ++v) {
        for (int u = 0; u < pair.width; ++u) {
          ASSERT_NEAR(truth.left(v, u), expected(u, v, pair.cx, 0), 1e-4);
          ASSERT_NEAR(truth.right(v, u), expected(u, v, pair.cx_right, pair.baseline_m), 1e-4);
        }
      }
    }
  }
}

}  // namespace
}  // namespace sprout::scenes
