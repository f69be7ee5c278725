#include "services/refine/range/unsure_points.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sprout::refine {
namespace {

constexpr double kNoisePx = 0.5;
constexpr float kUnsurePx = 2;

Seed PointAt(int u, int v, double disparity, double shared_px) {
  return {.u = static_cast<float>(u),
          .v = static_cast<float>(v),
          .u_right = static_cast<float>(u - disparity),
          .sigma_px = static_cast<float>(std::hypot(shared_px, kNoisePx))};
}

// Points every 10 px of 200×100; those from column 100 on are unsure.
std::vector<Seed> HalfUnsure() {
  std::vector<Seed> points;
  for (int v = 5; v < 100; v += 10) {
    for (int u = 5; u < 200; u += 10) points.push_back(PointAt(u, v, 20, u < 100 ? 0 : kUnsurePx));
  }
  return points;
}

TEST(UnsurePoints, NoiseAloneMakesNoPointUnsure) {
  EXPECT_FALSE(UnsurePoints::Is(PointAt(5, 5, 20, 0), kNoisePx));
  EXPECT_FALSE(UnsurePoints::Is(PointAt(5, 5, 20, 0.2), kNoisePx));
  EXPECT_TRUE(UnsurePoints::Is(PointAt(5, 5, 20, 0.3), kNoisePx));
}

TEST(UnsurePoints, StayWhereNothingIsSurer) {
  std::vector<Seed> points = HalfUnsure();
  for (Seed& point : points) point = PointAt(int(point.u), int(point.v), 20, kUnsurePx);
  UnsurePoints unsure;
  EXPECT_EQ(unsure.Drop(CellGrid(10, {200, 100}), kNoisePx, {}, points), 0);
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
  EXPECT_GT(unsure.Drop(CellGrid(10, {200, 100}), kNoisePx, stereo, points), 60);
  const auto sure = std::ranges::count_if(points, [](const Seed& p) { return p.u < 100; });
  EXPECT_EQ(sure, 100) << "a sure point was dropped";
}

}  // namespace
}  // namespace sprout::refine
