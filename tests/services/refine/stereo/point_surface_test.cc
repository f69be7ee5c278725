#include "services/refine/stereo/point_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace sprout::refine {
namespace {

constexpr double kCellPx = 5;
const cv::Size kCells(60, 40);

// A point every `steps` cells, in their middle.
std::vector<Seed> Points(int steps, const std::function<double(double, double)>& disparity) {
  std::vector<Seed> seeds;
  for (int y = 2; y < kCells.height; y += steps) {
    for (int x = 2; x < kCells.width; x += steps) {
      const auto u = static_cast<float>((x + 0.5) * kCellPx - 0.5);
      const auto v = static_cast<float>((y + 0.5) * kCellPx - 0.5);
      seeds.push_back({.u = u, .v = v, .u_right = u - static_cast<float>(disparity(u, v))});
    }
  }
  return seeds;
}

double SigmaPx(const std::vector<Seed>& seeds, cv::Point cell) {
  PointSurface surface;
  surface.Set(seeds, CellGrid(kCellPx, {300, 200}));
  return surface.SigmaPx(cell);
}

TEST(PointSurface, IsAsSureAsThePointsOnASlantLessWhatLiesUnseenBetweenThem) {
  std::vector<Seed> seeds = Points(4, [](double u, double v) { return 9 + 0.1 * u - 0.05 * v; });
  for (Seed& seed : seeds) seed.sigma_px = 0;
  // 0.025 px a px; the nearest points are two columns and two rows of 5 px away, and one column.
  EXPECT_NEAR(SigmaPx(seeds, {28, 20}), 0.025 * std::sqrt(200), 0.01);
  EXPECT_NEAR(SigmaPx(seeds, {29, 22}), 0.025 * 5, 0.01);
  for (Seed& seed : seeds) seed.sigma_px = 0.7F;
  EXPECT_NEAR(SigmaPx(seeds, {28, 20}), std::hypot(0.7, 0.025 * std::sqrt(200)), 0.01);
  EXPECT_EQ(SigmaPx(seeds, {30, 22}), 0.7F);  // has a point
}

TEST(PointSurface, IsUnsureWhereThePlanesAroundDisagree) {
  // A step of 6 px between the columns 30 and 34.
  const std::vector<Seed> seeds = Points(4, [](double u, double) { return u < 162 ? 30 : 24; });
  EXPECT_GT(SigmaPx(seeds, {32, 20}), 2);
  EXPECT_LT(SigmaPx(seeds, {28, 20}), 0.4);
  EXPECT_LT(SigmaPx(seeds, {36, 20}), 0.4);
}

TEST(PointSurface, IsLessSureTheMoreASurfaceBendsBetweenPoints) {
  const auto bowl = [](double u, double v) {
    return 20 + (std::pow(u - 150, 2) + std::pow(v - 100, 2)) / 2000;
  };
  const double fine = SigmaPx(Points(2, bowl), {29, 21});
  const double coarse = SigmaPx(Points(8, bowl), {29, 21});
  EXPECT_LT(fine, 0.2);
  EXPECT_GT(coarse, 2 * fine);
}

TEST(PointSurface, IsLessSureTheFartherTheOutermostPointsAre) {
  std::vector<Seed> seeds = Points(4, [](double, double) { return 12; });
  std::erase_if(seeds, [](const Seed& seed) { return seed.u > 150; });
  EXPECT_LT(SigmaPx(seeds, {24, 20}), 0.4);
  const double near = SigmaPx(seeds, {33, 22});
  const double far = SigmaPx(seeds, {55, 22});
  EXPECT_GT(near, 1);
  EXPECT_GT(far, 3 * near);
}

// A beam hits a row: what lies between two beams is enclosed all the same.
TEST(PointSurface, KnowsWhatLiesBetweenTheBeamsOfAScan) {
  std::vector<Seed> seeds = Points(1, [](double, double v) { return 10 + 0.05 * v; });
  std::erase_if(seeds, [](const Seed& seed) { return static_cast<int>(seed.v) % 40 != 12; });
  ASSERT_GT(seeds.size(), 200U);
  for (Seed& seed : seeds) seed.sigma_px = 0;
  EXPECT_NEAR(SigmaPx(seeds, {30, 11}), 0.025 * 5, 0.01);  // of rows 12 and 52 px down
  EXPECT_NEAR(SigmaPx(seeds, {30, 14}), 0.025 * 20, 0.01);
}

TEST(PointSurface, KnowsNothingWithoutPoints) {
  EXPECT_TRUE(std::isinf(SigmaPx({}, {5, 5})));
  const std::vector<Seed> outside = {{.u = -30, .v = 10, .u_right = -40}};
  EXPECT_TRUE(std::isinf(SigmaPx(outside, {5, 5})));
}

}  // namespace
}  // namespace sprout::refine
