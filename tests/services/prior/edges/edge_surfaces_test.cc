// Triangles across depth edges, and the two labels of their pixels.
#include "services/prior/edges/edge_surfaces.h"

#include <gmock/gmock.h>

#include <cmath>

namespace sprout::prior {
namespace {

using testing::UnorderedElementsAre;

// Level planes at the corners of a square.
struct Square {
  std::vector<Plane> planes;
  Triangulation triangulation;
  std::vector<SeedTriangle> triangles{{0, 1, 2}, {1, 3, 2}};

  explicit Square(std::array<float, 4> disparities) {
    std::vector<Seed> seeds;
    for (size_t i = 0; i < 4; ++i) {
      planes.push_back(
          {.u = i % 2 == 0 ? 2.F : 12.F, .v = i < 2 ? 1.F : 11.F, .disparity = disparities[i]});
      seeds.push_back({planes[i].u, planes[i].v, 0});
    }
    triangulation = Triangulate(seeds);
  }

  std::vector<EdgeTriangle> Edges(double edge_px = 0.5) const {
    return FindEdgeTriangles(planes, triangles, triangulation, edge_px);
  }

  EdgeLabels Labels() const {
    EdgeLabels labels;
    PaintLabels(Edges(), planes, 0.5, {16, 15}, labels);
    return labels;
  }
};

constexpr int kOne = DisparityImage::kCountsPerPixel;

bool HasLabels(const EdgeLabels& labels, int u, int v) {
  return labels.near(v, u) != DisparityImage::kInvalid;
}

TEST(EdgeTriangles, AreThoseWhoseSeedsLieOnTwoSurfaces) {
  EXPECT_EQ(Square({5, 6, 20, 20}).Edges().size(), 2U);
  EXPECT_EQ(Square({5, 5, 5, 20}).Edges().size(), 1U);
  EXPECT_EQ(Square({5, 5, 5, 20}).Edges(15.5).size(), 0U);
  EXPECT_EQ(Square({5, 5.5F, 5.2F, 5.9F}).Edges(1).size(), 0U);
  Square slanted({5, 6, 5, 6});  // one surface, though its seeds differ by a pixel
  for (Plane& plane : slanted.planes) plane.per_column = 0.1F;
  EXPECT_EQ(slanted.Edges().size(), 0U);
}

// Strips of triangles in three rows; the disparity falls between two columns.
TEST(EdgeTriangles, KnowTheSeedsInTwoRingsAround) {
  std::vector<Seed> seeds;
  std::vector<Plane> planes;
  for (int i = 0; i < 60; ++i) {
    const auto u = static_cast<float>(10 * (i / 2));
    const auto v = static_cast<float>(10 * (i % 2));
    planes.push_back({.u = u, .v = v, .disparity = i < 30 ? 20.F : 5.F});
    seeds.push_back({u, v, 0});
  }
  const Triangulation triangulation = Triangulate(seeds);
  const auto edges = FindEdgeTriangles(planes, triangulation.triangles, triangulation, 0.5);
  ASSERT_EQ(edges.size(), 2U);
  for (const EdgeTriangle& edge : edges) {
    EXPECT_THAT(edge.nearby(), testing::IsSupersetOf({26, 27, 28, 29, 30, 31, 32, 33}));
    for (int seed : edge.nearby()) EXPECT_TRUE(24 <= seed && seed <= 35) << seed;
  }
}

TEST(EdgeTriangles, OfSeedsWithThousandsOfNeighboursKnowSome) {
  std::vector<Seed> seeds = {{0, 0, 0}};
  std::vector<Plane> planes = {{.disparity = 20}};
  for (int i = 0; i < 5000; ++i) {
    const double angle = 2 * M_PI * i / 5000;
    const auto u = static_cast<float>(100 * std::cos(angle));
    const auto v = static_cast<float>(100 * std::sin(angle));
    seeds.push_back({u, v, 0});
    planes.push_back({.u = u, .v = v, .disparity = 5});
  }
  const Triangulation fan = Triangulate(seeds);
  const auto edges = FindEdgeTriangles(planes, fan.triangles, fan, 0.5);
  ASSERT_GT(edges.size(), 4000U);
  for (const EdgeTriangle& edge : edges) {
    EXPECT_EQ(edge.nearby().size(), EdgeTriangle::kMaxSeeds);
    EXPECT_THAT(edge.nearby(), testing::IsSupersetOf(edge.seeds));
  }
}

// The triangulation of the seeds does not know their copies beyond the hull.
TEST(EdgeTriangles, WithACornerBeyondTheHullKnowTheSeedsAroundTheOthers) {
  Square square({5, 6, 20, 20});
  square.planes.push_back({.u = 15, .v = 14, .disparity = 20});
  square.triangles = {{4, 2, 1}};
  const auto edges = square.Edges();
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_THAT(edges[0].nearby(), UnorderedElementsAre(0, 1, 2, 3));
}

TEST(EdgeLabels, AreTheSurfacesOnBothSidesOfTheGap) {
  const EdgeLabels two = Square({5, 6, 20, 20}).Labels();
  EXPECT_EQ(two.near(5, 2), 20 * kOne);
  EXPECT_EQ(two.far(1, 2), 5 * kOne);
  EXPECT_EQ(two.far(1, 12), 6 * kOne);
  EXPECT_EQ(two.far(2, 6), 5 * kOne);  // of the closer of its two seeds
  EXPECT_EQ(two.far(2, 8), 6 * kOne);
  EXPECT_EQ(two.triangle(2, 3), 0);
  EXPECT_EQ(two.triangle(10, 11), 1);
  EXPECT_FALSE(HasLabels(two, 1, 5));  // outside of the triangles
  EXPECT_FALSE(HasLabels(two, 5, 12));
}

TEST(EdgeLabels, AreNoneWhereSurfacesMeet) {
  Square crossing({5, 5, 7, 7});
  crossing.planes[0].per_row = crossing.planes[1].per_row = 0.4F;
  const EdgeLabels two = crossing.Labels();  // in row 6
  EXPECT_TRUE(HasLabels(two, 3, 2));
  EXPECT_FALSE(HasLabels(two, 3, 6));
  EXPECT_TRUE(HasLabels(two, 3, 9));
}

TEST(EdgeLabels, StayInRangeWhenPlanesAreSteep) {
  for (const float per_row : {-3.F, 500.F}) {
    Square steep({1, 2, 900, 1000});
    for (Plane& plane : steep.planes) plane.per_row = per_row;
    const EdgeLabels two = steep.Labels();
    int labelled = 0;
    for (int v = 0; v < two.near.rows; ++v) {
      for (int u = 0; u < two.near.cols; ++u) {
        if (!HasLabels(two, u, v)) continue;
        ++labelled;
        EXPECT_TRUE(0 <= two.far(v, u) && two.far(v, u) <= two.near(v, u)) << u << ", " << v;
      }
    }
    EXPECT_GT(labelled, 50);
  }
}

TEST(EdgeLabels, ForgetTheFrameBefore) {
  EdgeLabels labels = Square({5, 6, 20, 20}).Labels();
  ASSERT_TRUE(HasLabels(labels, 2, 5));
  PaintLabels({}, {}, 0.5, {16, 15}, labels);
  EXPECT_EQ(cv::countNonZero(labels.near != DisparityImage::kInvalid), 0);
}

}  // namespace
}  // namespace sprout::prior
