#include "services/prior/triangulation/triangulation.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <set>

#include "services/prior/triangulation/grid_cells.h"

namespace sprout::prior {
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

std::vector<Seed> Grid(int columns, int rows, float spacing = 10) {
  std::vector<Seed> seeds;
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < columns; ++u) {
      seeds.push_back(At(spacing * static_cast<float>(u), spacing * static_cast<float>(v)));
    }
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

TEST(Triangulation, HasNoSeedInsideTheCircleOfATriangle) {
  for (uint32_t seed = 0; seed < 5; ++seed) {
    const std::vector<Seed> seeds = RandomSeeds(60, seed);
    const std::vector<SeedTriangle> triangles = Triangulate(seeds).triangles;
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

TEST(Triangulation, HasNoTriangleForTooFewOrCollinearSeeds) {
  for (const std::vector<Seed>& seeds : {std::vector<Seed>{},
                                         {At(1, 1)},
                                         {At(1, 1), At(2, 2)},
                                         {At(1, 1), At(1, 1), At(1, 1)},
                                         {At(1, 1), At(2, 2), At(5, 5), At(9, 9)}}) {
    const Triangulation none = Triangulate(seeds);
    EXPECT_TRUE(none.triangles.empty());
    EXPECT_TRUE(none.hull.empty());
    for (size_t i = 0; i < seeds.size(); ++i) {
      EXPECT_TRUE(none.NeighboursOf(static_cast<int>(i)).empty());
    }
  }
}

TEST(Triangulation, CountsSeedsOnOnePositionOnce) {
  const Triangulation one =
      Triangulate(std::vector<Seed>{At(0, 0), At(4, 0), At(0, 4), At(0, 0), At(4, 0)});
  ASSERT_EQ(one.triangles.size(), 1u);
  EXPECT_THAT(one.triangles[0], testing::UnorderedElementsAre(0, 1, 2));
  EXPECT_THAT(one.NeighboursOf(0), testing::UnorderedElementsAre(1, 2));
  EXPECT_TRUE(one.NeighboursOf(3).empty());
}

TEST(Triangulation, TakesSeedsFromAnywhere) {
  const std::vector<Seed> seeds = {At(-1e30F, 3), At(1e30F, 1e9F), At(5, 5), At(6, -1e20F),
                                   At(7, 7)};
  const Triangulation far = Triangulate(seeds);
  EXPECT_GT(far.triangles.size(), 2u);
  for (const auto& [a, b, c] : far.triangles) EXPECT_TRUE(a != b && b != c && c != a);
}

// Four seeds of a grid lie on a circle: ties everywhere.
TEST(Triangulation, IsTheSameForSeedsInAnyOrder) {
  const std::vector<Seed> seeds = Grid(30, 20);
  const auto last = static_cast<int>(seeds.size()) - 1;
  const Triangulation first = Triangulate(seeds);
  EXPECT_EQ(first.triangles.size(), 2u * 29 * 19);
  const Triangulation again = Triangulate(std::vector<Seed>(seeds.rbegin(), seeds.rend()));
  ASSERT_EQ(again.triangles.size(), first.triangles.size());
  for (size_t i = 0; i < first.triangles.size(); ++i) {
    const auto& [a, b, c] = again.triangles[i];
    EXPECT_EQ(first.triangles[i], (SeedTriangle{last - a, last - b, last - c}));
  }
  for (int i = 0; i <= last; ++i) {
    std::vector<int> neighbours;
    for (int other : again.NeighboursOf(last - i)) neighbours.push_back(last - other);
    EXPECT_THAT(first.NeighboursOf(i), testing::ElementsAreArray(neighbours));
  }
}

// Euler: of n positions, h of them on the hull, 2n - 2 - h triangles.
TEST(Triangulation, CoversTheHull) {
  const Triangulation grid = Triangulate(Grid(30, 20));  // most of its hull lies on sides
  EXPECT_EQ(grid.hull.size(), 2u * (19 + 29));
  std::vector<Seed> round;
  for (int i = 0; i < 500; ++i) {
    const double angle = i * 2 * M_PI / 500;
    round.push_back(
        At(static_cast<float>(1000 * std::cos(angle)), static_cast<float>(1000 * std::sin(angle))));
  }
  const Triangulation circle = Triangulate(round);
  EXPECT_EQ(circle.triangles.size(), 498u);
  ASSERT_EQ(circle.hull.size(), 500u);
  for (size_t i = 0; i < 500; ++i) {  // clockwise as the image is seen: by growing angles
    EXPECT_EQ(circle.hull[(i + 1) % 500], (circle.hull[i] + 1) % 500);
  }
}

TEST(Triangulation, NeighboursShareATriangle) {
  const std::vector<Seed> seeds = RandomSeeds(300, 7);
  const Triangulation triangulation = Triangulate(seeds);
  std::vector<std::set<int>> expected(seeds.size());
  for (const SeedTriangle& triangle : triangulation.triangles) {
    for (int a : triangle) {
      for (int b : triangle) {
        if (a != b) expected[static_cast<size_t>(a)].insert(b);
      }
    }
  }
  for (size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_THAT(triangulation.NeighboursOf(static_cast<int>(i)),
                testing::UnorderedElementsAreArray(expected[i]));
  }
}

// What a ToF camera sees through a grid of rays: two surfaces with a step between them, so that the
// grid folds or tears there, noise, and points that were dropped.
std::vector<Seed> TofSeeds(float step_px, float noise_px, float lost, uint32_t seed) {
  constexpr int kColumns = 40;
  constexpr int kRows = 30;
  std::mt19937 random(seed);
  const auto even = [&] { return static_cast<float>(random() % 65536) / 65536; };
  std::vector<Seed> seeds;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const bool near = std::hypot(static_cast<float>(x) - 17, static_cast<float>(y) - 13) < 9;
      const float u = 10 * static_cast<float>(x) + (near ? step_px : 0) + noise_px * even();
      const float v = 10 * static_cast<float>(y) + noise_px * even();
      Seed at = At(u, v);
      at.tof_u = static_cast<int16_t>(x + 3);
      at.tof_v = static_cast<int16_t>(y + 2);
      if (even() >= lost) seeds.push_back(at);
    }
  }
  return seeds;
}

bool operator==(const Triangulation& one, const Triangulation& other) {
  bool same = one.triangles == other.triangles && one.hull == other.hull &&
              one.neighbours == other.neighbours && one.lists.size() == other.lists.size();
  for (size_t i = 0; same && i < one.lists.size(); ++i) {
    const auto a = one.NeighboursOf(static_cast<int>(i));
    const auto b = other.NeighboursOf(static_cast<int>(i));
    same = std::equal(a.begin(), a.end(), b.begin(), b.end());
  }
  return same;
}

TEST(Triangulation, IsTheSameWhetherTheGridOfTheTofImageIsKnownOrNot) {
  for (const float step_px : {0.F, 4.F, 12.F, -25.F, 33.F}) {
    for (const float noise_px : {0.F, 0.01F, 3.F, 30.F}) {
      for (const float lost : {0.F, 0.02F, 0.2F, 0.8F}) {
        std::vector<Seed> seeds = TofSeeds(step_px, noise_px, lost, 5);
        if (lost == 0.02F) {  // some of stereo between them, and one position twice
          for (int i = 0; i < 30; ++i) seeds.push_back(RandomSeeds(30, 3)[static_cast<size_t>(i)]);
          seeds.push_back(seeds[100]);
          seeds.back().tof_u = 20;
          std::shuffle(seeds.begin(), seeds.end(), std::mt19937(1));
        }
        const Triangulation known = Triangulate(seeds);
        for (Seed& seed : seeds) seed.tof_u = seed.tof_v = -1;
        EXPECT_TRUE(known == Triangulate(seeds))
            << "step " << step_px << ", noise " << noise_px << ", lost " << lost;
      }
    }
  }
}

TEST(Triangulation, IsTheSameWhereOneColumnOfCellsIsManyRowsWide) {
  // Triangles so flat that rounding hides on which side of their circles the fourth corner lies.
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, 0.05F);
  for (int scene = 0; scene < 300; ++scene) {
    const auto gap_px = static_cast<float>(45 + random() % 60);
    std::vector<Seed> seeds;
    for (int y = 0; y < 17; ++y) {
      for (int x = 0; x < 3; ++x) {
        const float beside = x == 2 ? gap_px : 0;
        seeds.push_back(At(100 + static_cast<float>(x) + beside + noise(random),
                           100 + static_cast<float>(y) + noise(random)));
        seeds.back().tof_u = static_cast<int16_t>(x);
        seeds.back().tof_v = static_cast<int16_t>(y);
      }
    }
    const Triangulation known = Triangulate(seeds);
    for (Seed& seed : seeds) seed.tof_u = seed.tof_v = -1;
    EXPECT_TRUE(known == Triangulate(seeds)) << "scene " << scene << ", gap " << gap_px;
  }
}

TEST(Triangulation, OfSeedsOnALineIsSoonDone) {
  std::vector<Seed> seeds;
  for (int u = 0; u < 60'000; ++u) seeds.push_back(At(static_cast<float>(u) / 4, 100));
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  EXPECT_TRUE(Triangulate(seeds).triangles.empty());
  seeds.push_back(At(0, 0));
  EXPECT_EQ(Triangulate(seeds).triangles.size(), 59'999U);
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(10));  // 40 if each looked at all others
}

TEST(GridCells, KnowTheTrianglesWhereTheGridIsIntact) {
  std::vector<Seed> seeds = TofSeeds(0, 2, 0, 1);
  std::vector<GridPoint> points;
  for (const Seed& seed : seeds) points.push_back({seed.u, seed.v, seed.tof_u, seed.tof_v});
  points[500].tof_u = -1;  // as if it was of stereo
  const GridCells cells(points);
  int inside = 0;
  for (size_t i = 0; i < points.size(); ++i) inside += cells.IsInside(static_cast<int>(i)) ? 1 : 0;
  EXPECT_GT(inside, 38 * 28 * 0.9);
  EXPECT_LE(inside, 38 * 28 - 9);  // that one and those around it
}

TEST(GridCells, HasNoneInOneRowOrColumnOfTheTofImage) {
  for (const bool in_a_row : {false, true}) {
    std::vector<Seed> seeds = Grid(6, 5);
    for (size_t i = 0; i < seeds.size(); ++i) {
      seeds[i].tof_u = static_cast<int16_t>(in_a_row ? i : 0);
      seeds[i].tof_v = static_cast<int16_t>(in_a_row ? 0 : i);
    }
    std::vector<Seed> unknown = seeds;
    for (Seed& seed : unknown) seed.tof_u = seed.tof_v = -1;
    EXPECT_EQ(Triangulate(seeds).triangles.size(), 2u * 5 * 4);
    EXPECT_EQ(Triangulate(seeds).triangles, Triangulate(unknown).triangles);
  }
}

TEST(Rings, GoFromNeighboursToTheirNeighbours) {
  const Triangulation grid = Triangulate(Grid(9, 9));
  Rings rings(grid);
  const int middle = 4 * 9 + 4;
  for (int round = 0; round < 2; ++round) {  // the second call starts anew
    EXPECT_THAT(rings.Around(std::span(&middle, 1), 0, 99), testing::ElementsAre(middle));
    EXPECT_EQ(rings.Around(std::span(&middle, 1), 1, 99).size(),
              1 + grid.NeighboursOf(middle).size());
    const std::span<const int> two = rings.Around(std::span(&middle, 1), 2, 99);
    EXPECT_EQ(two.size(), 19u);  // each diagonal the same way: hexagons
    EXPECT_EQ(std::set<int>(two.begin(), two.end()).size(), two.size());
  }
  EXPECT_EQ(rings.Around(std::span(&middle, 1), 2, 5).size(), 5u);
  const std::vector<int> unknown = {middle, 81, 1000};
  EXPECT_THAT(rings.Around(unknown, 0, 99), testing::ElementsAre(middle));
}

}  // namespace
}  // namespace sprout::prior
