#include "common/geometry/lens.h"

#include <gtest/gtest.h>

#include "common/geometry/projection.h"

namespace sprout {
namespace {

Rig RigWithLens() {
  Rig rig;
  rig.tof.width = 40;
  rig.tof.height = 30;
  rig.tof.fx = 50;
  rig.tof.fy = 51;
  rig.tof.cx = 20.5;
  rig.tof.cy = 13;
  rig.tof.distortion = {-0.2, 0.05, 0.001, -0.002, -0.01};
  return rig;
}

TEST(BrownLens, FindsThePixelOfTheDirectionOfAPixel) {
  const Lens lens = RigWithLens().tof.lens();
  for (const auto& [u, v] : {std::pair{0.0, 0.0}, {39.0, 29.0}, {39.5, 0.0}, {20.0, 13.0}}) {
    const Eigen::Vector2d again = PixelOfDirection(lens, DirectionOfPixel(lens, {u, v}));
    EXPECT_NEAR(again.x(), u, 1e-9);
    EXPECT_NEAR(again.y(), v, 1e-9);
  }
}

TEST(BrownLens, IsTheOneThatTheProjectorUndoes) {
  const Rig rig = RigWithLens();
  const TofProjector projector(rig);
  for (const auto& [u, v] : {std::pair{0, 0}, {39, 0}, {3, 28}, {20, 13}}) {
    const Eigen::Vector2d direction =
        DirectionOfPixel(rig.tof.lens(), {static_cast<double>(u), static_cast<double>(v)});
    EXPECT_NEAR(direction.x(), projector.ray(u, v).x(), 1e-8);
    EXPECT_NEAR(direction.y(), projector.ray(u, v).y(), 1e-8);
  }
}

}  // namespace
}  // namespace sprout
