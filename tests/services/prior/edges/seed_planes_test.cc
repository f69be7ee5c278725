#include "services/prior/edges/seed_planes.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "common/core/prior_map.h"
#include "services/prior/triangulation/interpolation.h"

namespace sprout::prior {
namespace {

constexpr int kSide = 20;  // seeds
constexpr double kSpacing = 10;

template <typename Disparity>
std::vector<Seed> Grid(const Disparity& disparity) {
  std::vector<Seed> seeds;
  for (int i = 0; i < kSide * kSide; ++i) {
    const auto u = static_cast<float>(kSpacing * (i % kSide));
    const auto v = static_cast<float>(kSpacing * (i / kSide));
    seeds.push_back({u, v, u - static_cast<float>(disparity(u, v))});
  }
  return seeds;
}

std::vector<Plane> Fit(const std::vector<Seed>& seeds) {
  const Triangulation triangulation = Triangulate(seeds);
  const double step_px = StepPx(seeds, triangulation.triangles, kSpacing, PriorConfig());
  return FitPlanes(seeds, triangulation, kSpacing, step_px, PriorConfig());
}

TEST(SeedPlanes, SpacingIsTheMedianSide) {
  std::vector<Seed> seeds = Grid([](float, float) { return 1; });
  EXPECT_NEAR(SpacingPx(seeds, Triangulate(seeds).triangles), kSpacing, 1e-6);
  EXPECT_EQ(SpacingPx({}, {}), 1);
}

TEST(SeedPlanes, HaveTheSlantWithAndWithoutNoise) {
  for (const double noise_px : {0.0, 1.5}) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal(0, 1);
    std::vector<Seed> seeds = Grid(
        [&](float u, float v) { return 10 + 0.05 * u - 0.02 * v + noise_px * normal(random); });
    for (Seed& seed : seeds) seed.sigma_px = static_cast<float>(0.05 + noise_px);
    const Plane plane = Fit(seeds)[10 * kSide + 10];  // at (100, 100)
    EXPECT_NEAR(plane.disparity, 13, 0.01 + 0.6 * noise_px);
    EXPECT_NEAR(plane.per_column, 0.05, 0.002 + noise_px / 30);
    EXPECT_NEAR(plane.per_row, -0.02, 0.002 + noise_px / 30);
    EXPECT_EQ(plane.sigma_px, seeds[0].sigma_px);
  }
}

// Beside stereo's noise a few exact points say where the surface is.
TEST(SeedPlanes, FollowTheSurerNeighbours) {
  std::mt19937 random(9);
  std::normal_distribution<double> normal(0, 0.3);
  std::vector<Seed> seeds = Grid([](float u, float) { return 10 + 0.05F * u; });
  for (size_t i = 0; i < seeds.size(); ++i) {
    if (i % 3 == 0) continue;  // of the ToF camera
    seeds[i].origin = SeedOrigin::kStereo;
    seeds[i].u_right -= static_cast<float>(normal(random));
    seeds[i].sigma_px = 0.3F;
  }
  double squares = 0;
  int count = 0;
  for (const Plane& plane : Fit(seeds)) {
    const double inside = kSpacing * (kSide - 2);
    if (plane.u < kSpacing || plane.v < kSpacing || plane.u > inside || plane.v > inside) continue;
    squares += std::pow(plane.disparity - 10 - 0.05 * plane.u, 2);
    ++count;
  }
  EXPECT_LT(std::sqrt(squares / count), 0.05);  // 0.08 where all count alike
}

// A slant that is counted in whole pixels looks like stairs, with steps that are three seeds wide.
TEST(SeedPlanes, TakeOffTheStepsInWhichDisparitiesAreCounted) {
  const auto truth = [](float u, float v) { return 20 + 0.03F * u + 0.002F * v; };
  const std::vector<Seed> seeds = Grid([&](float u, float v) { return std::round(truth(u, v)); });
  const std::vector<Plane> planes = Fit(seeds);
  double counted = 0;
  double smoothed = 0;
  for (size_t i = 0; i < seeds.size(); ++i) {
    const float d = truth(seeds[i].u, seeds[i].v);
    counted += std::abs(seeds[i].disparity() - d);
    smoothed += std::abs(planes[i].disparity - d);
  }
  EXPECT_LT(smoothed, 0.75 * counted);
}

// What differs by more than steps do is another surface.
TEST(SeedPlanes, LeaveDepthEdgesAsTheyAre) {
  const std::vector<Seed> seeds = Grid([](float u, float) { return u < 95 ? 12 : 16; });
  const std::vector<Plane> planes = Fit(seeds);
  for (size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_NEAR(planes[i].disparity, seeds[i].disparity(), 0.05);
  }
}

// Two slants that point away from the edge between them: planes that blend the two would be level.
TEST(SeedPlanes, KeepTheirSlantBesideADepthEdge) {
  const std::vector<Seed> seeds =
      Grid([](float u, float) { return u < 95 ? 40 - 0.06F * u : 10 + 0.06F * u; });
  const std::vector<Plane> planes = Fit(seeds);
  for (size_t row = 3; row < kSide - 3; ++row) {
    EXPECT_NEAR(planes[row * kSide + 9].per_column, -0.06, 0.01);
    EXPECT_NEAR(planes[row * kSide + 10].per_column, 0.06, 0.01);
  }
}

TEST(SeedPlanes, OfStereoAndNoisySeedsTakeTheDisparityOfThoseAround) {
  std::vector<Seed> seeds = Grid([](float, float) { return 20; });
  const size_t middle = 10 * kSide + 10;
  seeds[middle].u_right -= 4;
  EXPECT_NEAR(Fit(seeds)[middle].disparity, 24, 0.3);
  seeds[middle].u_right += 2;
  seeds[middle].origin = SeedOrigin::kStereo;
  EXPECT_NEAR(Fit(seeds)[middle].disparity, 20, 0.3);
  seeds[middle].origin = SeedOrigin::kTof;
  seeds[middle].sigma_px = 2;
  EXPECT_NEAR(Fit(seeds)[middle].disparity, 20, 0.3);
}

TEST(SeedPlanes, OfSeedsInNoTriangleAreLevel) {
  const std::vector<Seed> seeds = {{0, 0, -7}, {5, 0, -2}};
  const std::vector<Plane> planes = Fit(seeds);
  EXPECT_FLOAT_EQ(planes[0].disparity, 7);
  EXPECT_EQ(planes[0].per_column, 0);
}

// ExtendBeyondHull().

const cv::Size kSize(60, 40);

Plane Slant(float u, float v) {
  return {.u = u,
          .v = v,
          .disparity = 20 + 0.1F * u + 0.2F * v,
          .per_column = 0.1F,
          .per_row = 0.2F,
          .sigma_px = 0.05F};
}

// Seeds on one plane, which the fit has found, and their copies.
struct Extended {
  Extended(const std::vector<cv::Point2f>& positions, double reach_px) {
    std::vector<Seed> seeds;
    for (const cv::Point2f& at : positions) {
      planes.push_back(Slant(at.x, at.y));
      seeds.push_back({at.x, at.y, at.x - planes.back().disparity});
    }
    const Triangulation triangulation = Triangulate(seeds);
    triangles = triangulation.triangles;
    inside = triangles.size();
    ExtendBeyondHull(triangulation.hull, kSize, reach_px, PriorConfig(), planes, triangles);
    map = PriorMap(kSize);
    EXPECT_TRUE(Interpolate(planes, triangles, 0.5, map).has_value());
  }

  std::vector<Plane> planes;
  std::vector<SeedTriangle> triangles;
  size_t inside = 0;
  PriorMap map;
};

std::vector<cv::Point2f> Rectangle() {  // from (7, 5) to (49, 29)
  std::vector<cv::Point2f> positions;
  for (int v = 5; v < 35; v += 6) {
    for (int u = 7; u < 55; u += 6) positions.emplace_back(u, v);
  }
  return positions;
}

TEST(BeyondHull, APlaneGoesOnToEveryPixel) {
  const PriorMap map = Extended(Rectangle(), 100).map;
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      const Plane truth = Slant(static_cast<float>(u), static_cast<float>(v));
      ASSERT_NEAR(map.disparity.Px(u, v), truth.disparity, 0.05) << u << ", " << v;
      ASSERT_LT(map.sigma(v, u), kMaxSigmaCounts);
    }
  }
}

TEST(BeyondHull, WhereverItReachesIsOnThePlane) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::vector<cv::Point2f> positions;
    for (uint32_t i = 0; i < 4 + 2 * seed; ++i) {
      const auto u = 8 + static_cast<float>(random() % 2800) / 64;
      positions.emplace_back(u, 6 + static_cast<float>(random() % 1800) / 64);
    }
    const PriorMap map = Extended(positions, 15).map;
    for (int v = 0; v < kSize.height; ++v) {
      for (int u = 0; u < kSize.width; ++u) {
        if (map.sigma(v, u) == kMaxSigmaCounts) continue;
        const Plane truth = Slant(static_cast<float>(u), static_cast<float>(v));
        ASSERT_NEAR(map.disparity.Px(u, v), truth.disparity, 0.05) << u << ", " << v;
      }
    }
  }
}

TEST(BeyondHull, ReachesNoFurtherThanAskedAndKnowsLessThere) {
  const Extended extended(Rectangle(), 4);
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      const bool reached = 3 <= u && u <= 53 && 1 <= v && v <= 33;
      ASSERT_EQ(extended.map.sigma(v, u) < kMaxSigmaCounts, reached) << u << ", " << v;
    }
  }
  EXPECT_EQ(extended.map.sigma(17, 28), SigmaToCounts(0.05));
  // 4 px off: σ² = 0.05² + (0.05 · 4)² at two of three corners.
  EXPECT_EQ(extended.map.sigma(33, 28), SigmaToCounts(std::sqrt(0.0025 + 0.04 * 2 / 3)));
}

TEST(BeyondHull, LeavesSeedsOnTheBorderAndBeyondItWhereTheyAre) {
  for (const std::vector<cv::Point2f>& positions :
       {std::vector<cv::Point2f>{{0, 0}, {59, 0}, {0, 39}, {59, 39}},
        std::vector<cv::Point2f>{{-5, -5}, {80, -5}, {-5, 60}, {80, 60}}}) {
    const Extended extended(positions, 100);
    for (size_t i = 4; i < 8; ++i) {
      const cv::Point2f at(extended.planes[i].u, extended.planes[i].v);
      EXPECT_THAT(positions, testing::Contains(at));
    }
  }
}

TEST(BeyondHull, NeverLiesBeyondInfinityNorNearerThanTheImagesShow) {
  std::vector<Plane> planes = {Slant(20, 10), Slant(40, 10), Slant(30, 30)};
  for (Plane& plane : planes) plane.per_column = 50;
  std::vector<SeedTriangle> triangles = {{0, 1, 2}};
  ExtendBeyondHull(std::vector<int>{0, 1, 2}, kSize, 100, PriorConfig(), planes, triangles);
  ASSERT_EQ(planes.size(), 6u);
  for (const Plane& plane : planes) {
    EXPECT_GE(plane.disparity, 0);
    EXPECT_LT(plane.disparity, kSize.width);
  }
}

}  // namespace
}  // namespace sprout::prior
