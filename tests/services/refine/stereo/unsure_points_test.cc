#include "services/refine/stereo/unsure_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace sprout::refine {
namespace {

constexpr RangeNoise kPointNoise{.scale = 0.5};
constexpr float kUnsurePx = 2;

Seed PointAt(int u, int v, double disparity, double shared_px) {
  return {.u = static_cast<float>(u),
          .v = static_cast<float>(v),
          .u_right = static_cast<float>(u - disparity),
          .sigma_px = static_cast<float>(std::hypot(shared_px, kPointNoise.scale))};
}

// Points every 10 px of 200×100; those from column 100 on are unsure.
std::vector<Seed> HalfUnsure() {
  std::vector<Seed> points;
  for (int v = 5; v < 100; v += 10) {
    for (int u = 5; u < 200; u += 10) points.push_back(PointAt(u, v, 20, u < 100 ? 0 : kUnsurePx));
  }
  return points;
}

TEST(UnsurePoints, NoiseOfOnePixelMakesNoPointUnsure) {
  EXPECT_FALSE(UnsurePoints::IsUnsure(PointAt(5, 5, 20, 0), kPointNoise));
  EXPECT_FALSE(UnsurePoints::IsUnsure(PointAt(5, 5, 20, 0.2), kPointNoise));
  EXPECT_TRUE(UnsurePoints::IsUnsure(PointAt(5, 5, 20, 0.3), kPointNoise));
  for (const float noise_px : {1.0F, 3.0F}) {
    const Seed point{.u = 5, .v = 5, .u_right = -15, .sigma_px = noise_px};
    EXPECT_EQ(UnsurePoints::IsUnsure(point, {.scale = noise_px}), noise_px > 2);
  }
}

TEST(UnsurePoints, StayWhereNothingIsSurer) {
  std::vector<Seed> points = HalfUnsure();
  for (Seed& point : points) point = PointAt(int(point.u), int(point.v), 20, kUnsurePx);
  UnsurePoints unsure;
  EXPECT_EQ(unsure.Drop(CellGrid(10, {200, 100}), kPointNoise, {}, points), 0);
  EXPECT_EQ(points.size(), 200U);
}

TEST(UnsurePoints, GiveWayToSeedsOfStereoAmongThem) {
  std::vector<Seed> points = HalfUnsure();
  std::vector<Seed> stereo;
  for (int v = 5; v < 100; v += 30) {
    for (int u = 105; u < 200; u += 30) {
      stereo.push_back(PointAt(u, v, 23, 0));
      stereo.back().origin = SeedOrigin::kStereo;
    }
  }
  UnsurePoints unsure;
  EXPECT_GT(unsure.Drop(CellGrid(10, {200, 100}), kPointNoise, stereo, points), 60);
  const auto sure = std::ranges::count_if(points, [](const Seed& p) { return p.u < 100; });
  EXPECT_EQ(sure, 100) << "a sure point was dropped";
}

}  // namespace
}  // namespace sprout::refine
