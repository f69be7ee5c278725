#include "services/prior/border.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "services/prior/interpolation.h"

namespace sprout {
namespace {

const cv::Size kSize(60, 40);

float PlaneAt(float u, float v) { return 20 + 0.1F * u + 0.2F * v; }

// Seeds on one plane, which the fit has found.
struct Scene {
  explicit Scene(std::vector<Seed> on_plane) : seeds(std::move(on_plane)) {
    triangles = triangulator.Triangulate(seeds);
    for (Seed& seed : seeds) {
      const float disparity = PlaneAt(seed.u, seed.v);
      seed.u_right = seed.u - disparity;
      surface.planes.push_back({seed.u, seed.v, disparity, 0.1F, 0.2F});
    }
  }

  const BorderExtender::Extended& Extend(double reach_px = 100) {
    return extender.Extend(surface, triangles, triangulator.hull(), kSize, reach_px);
  }

  std::vector<Seed> seeds;
  Triangulator triangulator;
  std::vector<SeedTriangle> triangles;
  SeedSurface surface;
  BorderExtender extender;
};

Scene Grid() {
  std::vector<Seed> seeds;
  for (int v = 5; v < 35; v += 6) {
    for (int u = 7; u < 55; u += 6) {
      seeds.push_back({static_cast<float>(u), static_cast<float>(v), 0});
    }
  }
  return Scene(seeds);
}

Scene Cloud(int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Seed> seeds;
  for (int i = 0; i < count; ++i) {
    seeds.push_back({8 + static_cast<float>(random() % 2800) / 64,
                     6 + static_cast<float>(random() % 1800) / 64, 0});
  }
  return Scene(seeds);
}

double AreaOf(const BorderExtender::Extended& extended) {
  double area = 0;
  for (const auto& [i, j, k] : extended.triangles) {
    const auto at = [&](int plane) { return extended.surface.planes[static_cast<size_t>(plane)]; };
    const LocalPlane a = at(i), b = at(j), c = at(k);
    area += std::abs((b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v)) / 2;
  }
  return area;
}

void ExpectThePlaneEverywhere(const BorderExtender::Extended& extended) {
  std::vector<Seed> seeds;
  for (const LocalPlane& plane : extended.surface.planes) {
    seeds.push_back({plane.u, plane.v, plane.u - plane.disparity});
  }
  const auto map = InterpolateSeeds(seeds, extended.triangles, kSize);
  ASSERT_TRUE(map);
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      const float expected = PlaneAt(static_cast<float>(u), static_cast<float>(v));
      ASSERT_NEAR(map->Px(u, v), expected, 0.05) << u << ", " << v;
    }
  }
}

TEST(Border, ContinuesAPlaneToEveryPixel) {
  ExpectThePlaneEverywhere(Grid().Extend());
  for (uint32_t seed = 0; seed < 20; ++seed) {
    ExpectThePlaneEverywhere(Cloud(3 + static_cast<int>(seed) * 2, seed).Extend());
  }
}

TEST(Border, TilesTheImageWithoutOverlap) {
  const double image = (kSize.width - 1) * (kSize.height - 1);
  EXPECT_NEAR(AreaOf(Grid().Extend()), image, 0.1);
  for (uint32_t seed = 0; seed < 20; ++seed) {
    EXPECT_NEAR(AreaOf(Cloud(40, seed).Extend()), image, 0.1) << seed;
  }
}

TEST(Border, KeepsWhatIsThereAndAddsNothingWithoutAHull) {
  Scene scene = Grid();
  const auto& extended = scene.Extend();
  EXPECT_GT(extended.triangles.size(), scene.triangles.size());
  EXPECT_TRUE(
      std::equal(scene.triangles.begin(), scene.triangles.end(), extended.triangles.begin()));
  const auto& same = scene.extender.Extend(scene.surface, scene.triangles, {}, kSize, 100);
  EXPECT_EQ(same.triangles, scene.triangles);
  EXPECT_EQ(same.surface.planes.size(), scene.seeds.size());
}

TEST(Border, ReachesNoFurtherThanAsked) {
  Scene scene = Grid();  // from (7, 5) to (49, 29)
  const auto& extended = scene.Extend(4);
  EXPECT_NEAR(AreaOf(extended), (49 - 7 + 8) * (29 - 5 + 8), 0.1);
  for (const LocalPlane& plane : extended.surface.planes) {
    EXPECT_TRUE(3 <= plane.u && plane.u <= 53 && 1 <= plane.v && plane.v <= 33);
    EXPECT_NEAR(plane.disparity, PlaneAt(plane.u, plane.v), 1e-4);
  }
}

TEST(Border, LeavesSeedsOnItAndBeyondItAlone) {
  Scene on_it({{0, 0, 0}, {59, 0, 0}, {0, 39, 0}, {59, 39, 0}});
  EXPECT_EQ(on_it.Extend().triangles.size(), 2u);
  Scene beyond({{-5, -5, 0}, {80, -5, 0}, {-5, 60, 0}, {80, 60, 0}});
  EXPECT_EQ(beyond.Extend().triangles.size(), 2u);
}

TEST(Border, NeverGoesBeyondInfinityNorNearerThanTheImagesShow) {
  Scene scene = Grid();
  for (LocalPlane& plane : scene.surface.planes) plane.per_column = 50;
  for (const LocalPlane& plane : scene.Extend().surface.planes) {
    EXPECT_GE(plane.disparity, 0);
    EXPECT_LT(plane.disparity, kSize.width);
  }
}

}  // namespace
}  // namespace sprout
