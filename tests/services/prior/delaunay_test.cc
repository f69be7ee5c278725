#include "services/prior/delaunay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

namespace sprout {
namespace {

Seed At(float u, float v) { return {.u = u, .v = v, .u_right = u - 1}; }

std::vector<Seed> RandomSeeds(int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Seed> seeds;
  for (int i = 0; i < count; ++i) {
    const auto u = static_cast<float>(random() % 10000) / 64;
    const auto v = static_cast<float>(random() % 10000) / 64;
    seeds.push_back(At(u, v));
  }
  return seeds;
}

// > 0 when d lies inside the circle through the counter-clockwise triangle a, b, c.
long double InCircle(const Seed& a, const Seed& b, const Seed& c, const Seed& d) {
  const long double ax = a.u - d.u, ay = a.v - d.v, bx = b.u - d.u, by = b.v - d.v;
  const long double cx = c.u - d.u, cy = c.v - d.v;
  return (ax * ax + ay * ay) * (bx * cy - cx * by) - (bx * bx + by * by) * (ax * cy - cx * ay) +
         (cx * cx + cy * cy) * (ax * by - bx * ay);
}

TEST(Delaunay, NoSeedLiesInsideTheCircleOfATriangle) {
  for (uint32_t seed = 0; seed < 5; ++seed) {
    const std::vector<Seed> seeds = RandomSeeds(60, seed);
    const std::vector<SeedTriangle> triangles = TriangulateSeeds(seeds);
    ASSERT_GT(triangles.size(), 60u);
    for (const auto& [a, b, c] : triangles) {
      for (const Seed& d : seeds) {
        EXPECT_LE(InCircle(seeds[static_cast<size_t>(a)], seeds[static_cast<size_t>(b)],
                           seeds[static_cast<size_t>(c)], d),
                  1e-6L);
      }
    }
  }
}

TEST(Delaunay, HasNoTriangleForTooFewOrCollinearSeeds) {
  EXPECT_TRUE(TriangulateSeeds({}).empty());
  EXPECT_TRUE(TriangulateSeeds(std::vector<Seed>{At(1, 1)}).empty());
  EXPECT_TRUE(TriangulateSeeds(std::vector<Seed>{At(1, 1), At(2, 2)}).empty());
  EXPECT_TRUE(TriangulateSeeds(std::vector<Seed>{At(1, 1), At(2, 2), At(5, 5), At(9, 9)}).empty());
  EXPECT_TRUE(TriangulateSeeds(std::vector<Seed>{At(1, 1), At(1, 1), At(1, 1)}).empty());
}

TEST(Delaunay, CountsSeedsOnOnePositionOnce) {
  const std::vector<Seed> seeds = {At(0, 0), At(4, 0), At(0, 4), At(0, 0), At(4, 0)};
  const auto triangles = TriangulateSeeds(seeds);
  ASSERT_EQ(triangles.size(), 1u);
  const std::set<int> corners(triangles[0].begin(), triangles[0].end());
  EXPECT_EQ(corners, (std::set<int>{0, 1, 2}));
}

TEST(Delaunay, TakesSeedsFromAnywhere) {
  const std::vector<Seed> seeds = {At(-1e30F, 3), At(1e30F, 1e9F), At(5, 5), At(6, -1e20F),
                                   At(7, 7)};
  for (const auto& [a, b, c] : TriangulateSeeds(seeds)) {
    EXPECT_TRUE(a != b && b != c && c != a);
  }
}

TEST(Delaunay, HasNoTriangleWithoutArea) {
  // On one line, but not where positions are rounded.
  const std::vector<Seed> seeds = {At(0, 0), At(10, 3.01F), At(20, 6.02F), At(10, 20)};
  EXPECT_EQ(TriangulateSeeds(seeds).size(), 2u);
}

TEST(Delaunay, TriangulatesAGridTheSameWayInAnyOrder) {
  std::vector<Seed> seeds;
  for (int v = 0; v < 20; ++v) {
    for (int u = 0; u < 30; ++u)
      seeds.push_back(At(static_cast<float>(10 * u), static_cast<float>(10 * v)));
  }
  const auto triangles = TriangulateSeeds(seeds);
  EXPECT_EQ(triangles.size(), 2u * 29 * 19);
  EXPECT_EQ(TriangulateSeeds(seeds), triangles);
  // Shuffled seeds give the same triangles, named by other numbers.
  std::vector<Seed> reversed(seeds.rbegin(), seeds.rend());
  auto again = TriangulateSeeds(reversed);
  for (auto& triangle : again) {
    for (int& corner : triangle) corner = static_cast<int>(seeds.size()) - 1 - corner;
  }
  EXPECT_EQ(again, triangles);
}

TEST(Delaunay, DoesNotDependOnTheFramesBefore) {
  Triangulator kept;
  for (const int count : {1000, 10, 0, 1, 3, 4000, 500}) {
    const std::vector<Seed> seeds = RandomSeeds(count, static_cast<uint32_t>(count));
    Triangulator fresh;
    EXPECT_EQ(kept.Triangulate(seeds), fresh.Triangulate(seeds)) << count;
    EXPECT_EQ(kept.hull(), fresh.hull()) << count;
  }
}

// Euler: of n positions, h of them on the hull, 2n - 2 - h triangles.
TEST(Delaunay, CoversTheHull) {
  std::vector<Seed> round;
  for (int i = 0; i < 500; ++i) {
    const double angle = i * 2 * M_PI / 500;
    round.push_back(At(static_cast<float>(std::lround(64000 * std::cos(angle))) / 64,
                       static_cast<float>(std::lround(64000 * std::sin(angle))) / 64));
  }
  std::vector<Seed> grid;  // most of its hull lies on edges
  for (int v = 0; v < 20; ++v) {
    for (int u = 0; u < 30; ++u) grid.push_back(At(static_cast<float>(u), static_cast<float>(v)));
  }
  Triangulator triangulator;
  EXPECT_EQ(triangulator.Triangulate(round).size(), 498u);
  EXPECT_EQ(triangulator.hull().size(), 500u);
  EXPECT_EQ(triangulator.Triangulate(grid).size(), 2u * 19 * 29);
  EXPECT_EQ(triangulator.hull().size(), 2u * (19 + 29));
}

}  // namespace
}  // namespace sprout
