#include "services/tools/calibrate/scene/tof_patches.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sprout::calibrate {
namespace {

constexpr double kDistanceM = 1.5;

// An SR4000 in the place of the left camera.
Rig PatchRig() {
  Rig rig{.pair = {.width = 704,
                   .height = 576,
                   .focal_px = 560,
                   .cx = 351.5,
                   .cy = 287.5,
                   .cx_right = 351.5,
                   .baseline_m = 0.1},
          .tof = {}};
  rig.tof = TofOverLeft(rig.pair, {176, 144});
  return rig;
}

// A perfect sensor's view of a surface: the depth of each ray, by its direction.
template <typename Depth>
TofImage View(const TofProjector& projector, Depth depth) {
  TofImage tof{.depth_m = cv::Mat1f(projector.rig().tof.height, projector.rig().tof.width),
               .amplitude = {}};
  for (int v = 0; v < tof.depth_m.rows; ++v) {
    for (int u = 0; u < tof.depth_m.cols; ++u) {
      tof.depth_m(v, u) = static_cast<float>(depth(projector.ray(u, v)));
    }
  }
  return tof;
}

// A ball on the optical axis whose front is at kDistanceM, before a wall.
double BallDepth(const Eigen::Vector3d& ray, double radius_m) {
  const double centre_m = kDistanceM + radius_m;
  const double square = ray.squaredNorm();
  const double root = centre_m * centre_m - square * (centre_m * centre_m - radius_m * radius_m);
  return root < 0 ? 2 * kDistanceM : (centre_m - std::sqrt(root)) / square;
}

TEST(TofPatches, AreOnPlanesAndNotOnABall) {
  const TofProjector projector(PatchRig());
  const cv::Point2d middle(351.5, 287.5);
  for (const double slant : {0.0, 0.5}) {
    const TofImage wall = View(
        projector, [&](const Eigen::Vector3d& ray) { return kDistanceM / (1 + slant * ray.x()); });
    const std::optional<TofPatch> patch = TofPatches(wall, projector).At(middle);
    ASSERT_TRUE(patch);
    EXPECT_NEAR(patch->distance_m, kDistanceM / std::hypot(1, slant), 1e-4);
  }
  const auto ball = [&](double radius_m) {
    const TofImage view =
        View(projector, [&](const Eigen::Vector3d& ray) { return BallDepth(ray, radius_m); });
    return TofPatches(view, projector).At(middle);
  };
  EXPECT_FALSE(ball(0.1));
  // Hardly bent over the patch.
  EXPECT_TRUE(ball(1));
}

// The noise of a sensor is no bend.
TEST(TofPatches, AreOnNoisyPlanes) {
  const TofProjector projector(PatchRig());
  cv::RNG random(7);
  const TofImage wall =
      View(projector, [&](const Eigen::Vector3d&) { return kDistanceM + random.gaussian(0.003); });
  const TofPatches patches(wall, projector);
  int found = 0;
  int places = 0;
  for (int y = 40; y < 540; y += 20) {
    for (int x = 40; x < 660; x += 20) {
      found += patches.At(cv::Point2d(x, y)) ? 1 : 0;
      ++places;
    }
  }
  EXPECT_GT(found, 0.98 * places);
}

}  // namespace
}  // namespace sprout::calibrate
