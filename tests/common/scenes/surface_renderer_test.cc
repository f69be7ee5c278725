#include "common/scenes/surface_renderer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sprout::scenes {
namespace {

constexpr float kNoDepth = std::numeric_limits<float>::quiet_NaN();
constexpr float kFarPx = 10;
constexpr float kNearPx = 30;
constexpr float kFarM = 1;  // f·b / 10 px
constexpr float kNearM = 10.f / 30;

// A board in columns 50 to 69 of the left image, before a wall; f·b = 10 px·m. The ToF camera
// stands in the middle between the cameras, so it sees the board 15 px and the wall 5 px further
// left than the left camera does.
struct TwoPlanes {
  TwoPlanes() {
    rig.pair = {.width = 100,
                .height = 60,
                .focal_px = 100,
                .cx = 49.5,
                .cy = 29.5,
                .cx_right = 49.5,
                .baseline_m = 0.1};
    rig.tof.width = 100;
    rig.tof.height = 60;
    rig.tof.fx = rig.tof.fy = 100;
    rig.tof.cx = 49.5;
    rig.tof.cy = 29.5;
    rig.tof.left_from_tof_translation_m.x() = 0.05;
    const cv::Rect board(50, 20, 20, 20);
    const cv::Rect board_in_right(20, 20, 20, 20);
    truth.left(board) = kNearPx;
    truth.right(board_in_right) = kNearPx;
    left(board) = 200;
    right(board_in_right) = 200;
  }

  TofSamples Render() const { return RenderSurface(rig, truth, left, right); }

  Rig rig;
  GroundTruth truth{cv::Mat1f(60, 100, kFarPx), cv::Mat1f(60, 100, kFarPx)};
  cv::Mat1b left = cv::Mat1b(60, 100, uint8_t{100});
  cv::Mat1b right = cv::Mat1b(60, 100, uint8_t{100});
};

// Samples next to the middle of a ToF pixel.
float DepthAt(const TofSamples& samples, int u, int v) {
  return samples.depth_m(v * TofSamples::kPerSide + 2, u * TofSamples::kPerSide + 2);
}
float AlbedoAt(const TofSamples& samples, int u, int v) {
  return samples.albedo(v * TofSamples::kPerSide + 2, u * TofSamples::kPerSide + 2);
}

TEST(SurfaceRenderer, ShowsTheBoardWhereTheParallaxPutsIt) {
  const TofSamples samples = TwoPlanes().Render();
  for (int u = 10; u < 90; ++u) {
    const bool on_board = u >= 35 && u < 55;
    EXPECT_NEAR(DepthAt(samples, u, 30), on_board ? kNearM : kFarM, 1e-5) << u;
    EXPECT_NEAR(AlbedoAt(samples, u, 30), (on_board ? 200 : 100) / 255.0, 1e-6) << u;
    EXPECT_NEAR(DepthAt(samples, u, 10), kFarM, 1e-5) << u;
  }
}

TEST(SurfaceRenderer, SeesBackgroundThatTheLeftCameraDoesNot) {
  // The board ends at the ToF camera's column 54. The left camera sees the wall beside it from its
  // column 70 on, which is the ToF camera's 65: what lies between, only the right truth knows.
  TwoPlanes scene;
  for (int u = 56; u < 64; ++u) EXPECT_NEAR(DepthAt(scene.Render(), u, 30), kFarM, 1e-5) << u;
  scene.truth.right = cv::Mat1f();
  const TofSamples left_only = scene.Render();
  for (int u = 56; u < 64; ++u) EXPECT_TRUE(std::isnan(DepthAt(left_only, u, 30))) << u;
  EXPECT_NEAR(DepthAt(left_only, 66, 30), kFarM, 1e-5);
  EXPECT_NEAR(DepthAt(left_only, 54, 30), kNearM, 1e-5);
}

TEST(SurfaceRenderer, PutsWhatOnlyTheRightCameraSeesInFront) {
  TwoPlanes scene;
  scene.truth.left = kFarPx;  // the left truth does not know the board
  const TofSamples samples = scene.Render();
  for (int u = 36; u < 54; ++u) EXPECT_NEAR(DepthAt(samples, u, 30), kNearM, 1e-5) << u;
}

TEST(SurfaceRenderer, LeavesWhatNobodyKnowsUnknown) {
  TwoPlanes scene;
  scene.truth.left(cv::Rect(0, 0, 100, 15)) = kNoDepth;
  scene.truth.right(cv::Rect(0, 0, 100, 15)) = kNoDepth;
  const TofSamples samples = scene.Render();
  EXPECT_TRUE(std::isnan(DepthAt(samples, 50, 5)));
  EXPECT_EQ(AlbedoAt(samples, 50, 5), 0);
  EXPECT_FALSE(std::isnan(DepthAt(samples, 50, 20)));
}

TEST(SurfaceRenderer, LeavesNoGapInASlantedSurface) {
  TwoPlanes scene;
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 100; ++u) {
      scene.truth.left(v, u) = 20 + std::round(0.4f * static_cast<float>(u));
    }
  }
  scene.truth.right = cv::Mat1f();
  const TofSamples samples = scene.Render();
  for (int y = 20; y < 220; ++y) {
    for (int x = 20; x < 240; ++x) ASSERT_FALSE(std::isnan(samples.depth_m(y, x))) << x << " " << y;
  }
}

TEST(SurfaceRenderer, LooksFromThePoseOfTheCameraThroughItsLens) {
  TwoPlanes scene;
  scene.truth = {cv::Mat1f(60, 100, kFarPx), {}};
  scene.rig.tof.left_from_tof_translation_m = {0, 0, 0.25};
  EXPECT_NEAR(DepthAt(scene.Render(), 50, 30), 0.75, 1e-5);

  scene.rig.tof.left_from_tof_translation_m = {0, 0, 0};
  scene.left(30, 70) = 255;
  EXPECT_EQ(AlbedoAt(scene.Render(), 70, 30), 1);
  scene.rig.tof.distortion[0] = -1;
  // 20.5 px from the middle, r = 0.205: seen at 20.5 · (1 − r²) = 19.6 px.
  EXPECT_EQ(scene.Render().albedo(30 * 4 + 1, 278), 1);  // (49.5 + 19.6 + 0.5) · 4
}

}  // namespace
}  // namespace sprout::scenes
