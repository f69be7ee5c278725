#include "services/prior/edges/outline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace sprout::prior {
namespace {

Seed OutlineSeed(float u, float v) { return {.u = u, .v = v, .u_right = u - 5}; }

double AreaOf(const std::vector<Seed>& seeds, const std::vector<SeedTriangle>& triangles) {
  double area = 0;
  for (const auto& [i, j, k] : triangles) {
    const Seed &a = seeds[static_cast<size_t>(i)], &b = seeds[static_cast<size_t>(j)],
               &c = seeds[static_cast<size_t>(k)];
    area += std::abs((double{b.u} - a.u) * (double{c.v} - a.v) -
                     (double{b.v} - a.v) * (double{c.u} - a.u)) /
            2;
  }
  return area;
}

// Of a closed line of seeds.
double AreaIn(const std::vector<Seed>& seeds, const std::vector<int>& outline) {
  double twice = 0;
  for (size_t i = 0; i < outline.size(); ++i) {
    const Seed& a = seeds[static_cast<size_t>(outline[i])];
    const Seed& b = seeds[static_cast<size_t>(outline[(i + 1) % outline.size()])];
    twice += double{a.u} * b.v - double{b.u} * a.v;
  }
  return std::abs(twice) / 2;
}

// 12 × 5 seeds 10 px apart, the rows downwards from v = 20.
std::vector<Seed> TwelveByFive() {
  std::vector<Seed> seeds;
  for (int i = 0; i < 60; ++i) {
    seeds.push_back(
        OutlineSeed(static_cast<float>(10 * (i % 12)), static_cast<float>(20 + 10 * (i / 12))));
  }
  return seeds;
}

TEST(Outline, LeadsAlongARowThatASeedFurtherOutSpans) {
  std::vector<Seed> seeds = TwelveByFive();
  const Triangulation grid = Triangulate(seeds);
  seeds.push_back(OutlineSeed(0, 16));
  seeds.push_back(OutlineSeed(110, 16));
  const Triangulation before = Triangulate(seeds);
  Triangulation after = before;
  TakeOffFlatTriangles(seeds, 15, 10, after);
  // The hull led from one of the two to the other. Now all of the first row lie on the outline.
  EXPECT_EQ(before.hull.size(), grid.hull.size() + 2 - 10);
  EXPECT_EQ(after.hull.size(), grid.hull.size() + 2);
  for (int i = 0; i < 12; ++i) EXPECT_THAT(after.hull, testing::Contains(i));
  // What was between it and that side is gone: the two triangles beside the ends stay.
  EXPECT_DOUBLE_EQ(AreaOf(seeds, before.triangles), 110 * 44);
  EXPECT_DOUBLE_EQ(AreaOf(seeds, after.triangles), 110 * 40 + 2 * (10 * 4 / 2));
  EXPECT_DOUBLE_EQ(AreaIn(seeds, after.hull), AreaOf(seeds, after.triangles));
  EXPECT_EQ(before.neighbours, after.neighbours);
}

TEST(Outline, StaysWhereSidesAreShortOrTrianglesDeep) {
  std::vector<Seed> seeds = TwelveByFive();
  seeds.push_back(OutlineSeed(0, 16));
  seeds.push_back(OutlineSeed(110, 16));
  const Triangulation before = Triangulate(seeds);
  for (const auto& [longest_px, deepest_px] : {std::pair(111.0, 10.0), {30.0, 3.9}}) {
    Triangulation after = before;
    TakeOffFlatTriangles(seeds, longest_px, deepest_px, after);
    EXPECT_EQ(after.hull, before.hull);
    EXPECT_EQ(after.triangles, before.triangles);
  }
  Triangulation none;
  TakeOffFlatTriangles({}, 30, 10, none);
  EXPECT_TRUE(none.hull.empty());
}

TEST(Outline, HoldsEverySeedOnceAndAllTrianglesThatAreLeft) {
  std::vector<Seed> seeds;
  uint32_t random = 1;
  for (int i = 0; i < 500; ++i) {
    const auto next = [&] {
      return static_cast<float>((random = random * 1664525 + 1013904223) >> 16);
    };
    const float u = next();
    seeds.push_back(OutlineSeed(u / 100, next() / 400));
  }
  const Triangulation before = Triangulate(seeds);
  Triangulation after = before;
  TakeOffFlatTriangles(seeds, 20, 15, after);
  EXPECT_GT(after.hull.size(), before.hull.size() + 10);
  std::vector<int> sorted = after.hull;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(std::adjacent_find(sorted.begin(), sorted.end()), sorted.end());
  EXPECT_EQ(before.triangles.size() - after.triangles.size(),
            after.hull.size() - before.hull.size());
  EXPECT_NEAR(AreaIn(seeds, after.hull), AreaOf(seeds, after.triangles), 1e-6 * 655 * 163);
}

}  // namespace
}  // namespace sprout::prior
