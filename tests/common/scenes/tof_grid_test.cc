#include "common/scenes/tof_grid.h"

#include <gmock/gmock.h>

#include <cmath>
#include <vector>

#include "common/config/config_error.h"
#include "common/geometry/projection.h"
#include "tests/common/testing/thrown.h"

namespace sprout::scenes {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

RectifiedPair SomePair(int width, int height) {
  RectifiedPair pair{.width = width, .height = height};
  pair.focal_px = 1.1 * width;
  pair.cx = 0.47 * width;
  pair.cy = 0.52 * height;
  pair.cx_right = pair.cx + 0.03 * width;
  pair.baseline_m = 0.16;
  return pair;
}

// A disparity of its own for every pixel, 5 to 205 px.
cv::Mat1f SomeDisparity(const RectifiedPair& pair) {
  cv::Mat1f disparity(pair.size());
  for (int v = 0; v < pair.height; ++v) {
    for (int u = 0; u < pair.width; ++u) {
      disparity(v, u) = 5 + static_cast<float>((u * 7919 + v * 104729) % 20000) / 100;
    }
  }
  return disparity;
}

TEST(TofGrid, ProjectsBackOntoItsPixelsAndDisparities) {
  for (const auto& [width, height, step] :
       {std::tuple{1330, 1110, 10}, {641, 481, 7}, {33, 18, 1}, {20, 30, 20}, {64, 48, 3}}) {
    const RectifiedPair pair = SomePair(width, height);
    const cv::Mat1f disparity = SomeDisparity(pair);
    const Rig rig{pair, TofGridCamera(pair, step)};
    const TofImage tof = SampleTofGrid(pair, step, disparity);
    EXPECT_EQ(tof.depth_m.size(), cv::Size(width / step, height / step));
    ASSERT_EQ(tof.depth_m.size(), cv::Size(rig.tof.width, rig.tof.height));

    int behind = 0;
    const std::vector<ProjectedPoint> points = TofProjector(rig).Project(tof, behind);
    EXPECT_EQ(behind, 0);
    ASSERT_EQ(points.size(), tof.depth_m.total());
    for (const ProjectedPoint& point : points) {
      const int u = point.tof_u * step + step / 2;
      const int v = point.tof_v * step + step / 2;
      ASSERT_NEAR(point.seed.u, u, 1e-3);
      ASSERT_NEAR(point.seed.v, v, 1e-3);
      ASSERT_NEAR(point.seed.disparity(), disparity(v, u), 2e-3);
    }
  }
}

TEST(TofGrid, StandsAtTheLeftCameraWithoutDistortion) {
  const TofCamera tof = TofGridCamera(SomePair(640, 480), 10);
  EXPECT_TRUE(tof.left_from_tof_rotation.isApprox(Eigen::Quaterniond::Identity(), 0));
  EXPECT_EQ(tof.left_from_tof_translation_m, Eigen::Vector3d::Zero());
  EXPECT_THAT(tof.distortion, testing::Each(0));
}

TEST(TofGrid, HasNoReturnWithoutAPositiveFiniteDepth) {
  RectifiedPair pair = SomePair(40, 40);
  pair.cx_right = pair.cx + 2;  // infinity at d = −2
  cv::Mat1f disparity(pair.size(), 8);
  disparity(5, 5) = kNaN;
  disparity(5, 15) = -2;
  disparity(5, 25) = -3;
  disparity(5, 35) = std::numeric_limits<float>::infinity();  // depth 0
  const TofImage tof = SampleTofGrid(pair, 10, disparity);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(std::isnan(tof.depth_m(0, i))) << i;
  EXPECT_FLOAT_EQ(tof.depth_m(1, 0), static_cast<float>(pair.DepthFromDisparity(8)));
  EXPECT_TRUE(tof.amplitude.empty());
}

TEST(TofGrid, RefusesAStepThatLeavesNoPoint) {
  for (int step : {0, -1, 31}) {
    EXPECT_THAT(Thrown<ConfigError>([&] { TofGridCamera(SomePair(40, 30), step); }),
                testing::HasSubstr("allowed: 1 to 30"));
  }
}

}  // namespace
}  // namespace sprout::scenes
