#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>

#include "common/geometry/lens.h"
#include "common/geometry/projection.h"
#include "common/scenes/sr4000.h"
#include "tests/common/scenes/some_pair.h"

namespace sprout::scenes {
namespace {

TEST(Sr4000, StandsBetweenTheCamerasWithALensOfItsOwn) {
  const TofCamera camera = Sr4000(SomePair(), {}, 1).calibrated();
  EXPECT_EQ(cv::Size(camera.width, camera.height), cv::Size(176, 144));
  EXPECT_DOUBLE_EQ(camera.left_from_tof_translation_m.x(), 0.06);
  EXPECT_LT(camera.left_from_tof_translation_m.y(), 0);  // up
  const double turn = camera.left_from_tof_rotation.angularDistance(Eigen::Quaterniond::Identity());
  EXPECT_GT(turn, 0.005);
  EXPECT_LT(turn, 0.1);
  EXPECT_LT(camera.distortion[0], 0);  // barrel
  EXPECT_THAT(camera.distortion, testing::Each(testing::Ne(0)));
  Sr4000Config config;
  config.set_focal_px(220);
  EXPECT_DOUBLE_EQ(Sr4000(SomePair(), config, 1).calibrated().fx, 220);
}

TEST(Sr4000, SeesEverythingThatBothCamerasSee) {
  const RectifiedPair pair = SomePair();
  const TofCamera camera = Sr4000(pair, {}, 1).calibrated();
  for (const float disparity : {0.f, 51.f, 102.f}) {
    for (const float u : {disparity, 639.f}) {
      for (const float v : {0.f, 479.f}) {
        const Eigen::Vector3d in_left = PointFromSeed(pair, {u, v, u - disparity});
        const Eigen::Vector3d in_tof = camera.left_from_tof_rotation.conjugate() *
                                       (in_left - camera.left_from_tof_translation_m);
        const Eigen::Vector2d pixel = PixelOfDirection(camera.lens(), in_tof.hnormalized());
        EXPECT_TRUE(pixel.x() > -0.5 && pixel.x() < 175.5 && pixel.y() > -0.5 && pixel.y() < 143.5)
            << u << " " << v << " " << disparity << ": " << pixel.transpose();
      }
    }
  }
}

TEST(Sr4000, MovesProjectedPointsByTheCalibrationError) {
  const RectifiedPair pair = SomePair();
  const TofImage wall{cv::Mat1f(144, 176, 3.f), {}};
  for (const double error_px : {0.0, 1.0, 2.5, 10.0}) {
    Sr4000Config config;
    config.set_calibration_error_px(error_px);
    const Sr4000 camera(pair, config, 1);
    int behind = 0;
    const auto said = TofProjector({pair, camera.calibrated()}).Project(wall, behind);
    const auto truth = TofProjector({pair, camera.actual()}).Project(wall, behind);
    ASSERT_EQ(said.size(), truth.size());
    double sum = 0;
    for (size_t i = 0; i < said.size(); ++i) {
      EXPECT_LE(said[i].seed.u, truth[i].seed.u);
      EXPECT_LE(said[i].seed.v, truth[i].seed.v);
      sum += std::hypot(said[i].seed.u - truth[i].seed.u, said[i].seed.v - truth[i].seed.v);
    }
    EXPECT_NEAR(sum / static_cast<double>(said.size()), error_px, 0.15 * error_px);
  }
}

}  // namespace
}  // namespace sprout::scenes
