// Who is next to whom in the triangulation.
#include "services/prior/seed_neighbours.h"

#include <gtest/gtest.h>

#include <set>
#include <span>
#include <vector>

namespace sprout {
namespace {

TEST(SeedNeighbours, AreThoseOfTheTriangles) {
  SeedNeighbours neighbours;
  neighbours.Find(5, std::vector<SeedTriangle>{{0, 1, 2}, {1, 3, 2}});
  const auto of = [&](int seed) {
    const std::span<const int> found = neighbours.Of(seed);
    return std::set<int>(found.begin(), found.end());
  };
  EXPECT_EQ(of(0), (std::set<int>{1, 2}));
  EXPECT_EQ(of(1), (std::set<int>{0, 2, 3}));
  EXPECT_EQ(neighbours.Of(1).size(), 3U);
  EXPECT_TRUE(of(4).empty());
}

TEST(Surroundings, GrowStepByStep) {
  SeedNeighbours neighbours;  // a row of triangles, each seed a neighbour of the next two
  std::vector<SeedTriangle> strip;
  for (int i = 0; i + 2 < 20; ++i) strip.push_back({i, i + 1, i + 2});
  neighbours.Find(20, strip);
  Surroundings surroundings;
  surroundings.Set(neighbours);
  for (const int start : {10, 3}) {
    const auto reached = [&] {
      const std::span<const int> seeds = surroundings.reached();
      return std::multiset<int>(seeds.begin(), seeds.end());
    };
    surroundings.Start(std::vector{start});
    EXPECT_EQ(reached(), (std::multiset<int>{start}));
    surroundings.Widen(100);
    EXPECT_EQ(reached(), (std::multiset<int>{start - 2, start - 1, start, start + 1, start + 2}));
    surroundings.Widen(6);
    EXPECT_EQ(reached().size(), 6U);
  }
}

}  // namespace
}  // namespace sprout
