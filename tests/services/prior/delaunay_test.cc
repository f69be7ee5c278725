#include "services/prior/delaunay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <random>
#include <set>
#include <utility>

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

std::vector<Seed> OnACircle(int count) {
  std::vector<Seed> seeds;
  for (int i = 0; i < count; ++i) {
    const double angle = i * 2 * M_PI / count;
    seeds.push_back(At(static_cast<float>(std::lround(64000 * std::cos(angle))) / 64,
                       static_cast<float>(std::lround(64000 * std::sin(angle))) / 64));
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
  const std::vector<Seed> round = OnACircle(500);
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

// What seams must not change: many seeds are triangulated in strips.
class Strips : public testing::TestWithParam<std::vector<Seed>> {};

std::set<SeedTriangle> InAnyOrder(const std::vector<SeedTriangle>& triangles) {
  std::set<SeedTriangle> set;
  for (SeedTriangle triangle : triangles) {
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                triangle.end());
    set.insert(triangle);
  }
  return set;
}

TEST_P(Strips, GiveTheTrianglesOfTheWhole) {
  const std::vector<Seed>& seeds = GetParam();
  std::map<std::pair<int, int>, int> first;
  for (const Seed& seed : seeds) {
    first.try_emplace({std::lround(seed.v * 64), std::lround(seed.u * 64)},
                      static_cast<int>(&seed - seeds.data()));
  }
  std::vector<MeshPosition> positions;
  for (const auto& [at, seed] : first) positions.push_back({at.second, at.first, seed});
  DelaunayMesh whole;
  whole.Triangulate(positions);
  Triangulator triangulator;
  const std::vector<SeedTriangle>& triangles = triangulator.Triangulate(seeds);
  const std::set<SeedTriangle> set = InAnyOrder(triangles);
  EXPECT_EQ(set.size(), triangles.size());
  EXPECT_EQ(set, InAnyOrder(whole.triangles()));
  const std::vector<int>& hull = triangulator.hull();
  EXPECT_EQ(std::set<int>(hull.begin(), hull.end()),
            std::set<int>(whole.hull().begin(), whole.hull().end()));
  EXPECT_EQ(hull.size(), whole.hull().size());
}

TEST_P(Strips, GiveTheSameInTheSameOrderWithAnyNumberOfThreads) {
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const std::vector<SeedTriangle> alone = TriangulateSeeds(GetParam());
  cv::setNumThreads(4);
  EXPECT_EQ(TriangulateSeeds(GetParam()), alone);
  cv::setNumThreads(threads);
}

template <typename HasSeed>
std::vector<Seed> GridWhere(int columns, int rows, const HasSeed& has_seed) {
  std::vector<Seed> seeds;
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < columns; ++u) {
      if (has_seed(u, v)) seeds.push_back(At(static_cast<float>(8 * u), static_cast<float>(8 * v)));
    }
  }
  return seeds;
}

// Two rows that are far apart, so that all triangles cross the seam; and more on one line than a
// strip takes.
std::vector<Seed> Rows(int count) {
  std::vector<Seed> seeds;
  for (int i = 0; i < count; ++i) seeds.push_back(At(static_cast<float>(i), 0));
  for (int i = 0; i < 9; ++i) seeds.push_back(At(static_cast<float>(i * count) / 10, 900));
  return seeds;
}

INSTANTIATE_TEST_SUITE_P(
    Delaunay, Strips,
    testing::Values(RandomSeeds(3000, 1), RandomSeeds(8000, 2),
                    GridWhere(70, 50, [](int, int) { return true; }),
                    GridWhere(90, 60, [](int u, int v) { return std::hypot(u - 40, v - 33) > 20; }),
                    GridWhere(90, 60, [](int, int v) { return v < 20 || v > 50; }),
                    GridWhere(2, 2000, [](int u, int v) { return u == 0 || v % 7 == 0; }),
                    OnACircle(4000), Rows(2500)));

}  // namespace
}  // namespace sprout
