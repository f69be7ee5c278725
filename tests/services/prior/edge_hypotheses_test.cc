// Triangles across depth edges, and the two surfaces that their pixels may lie on.
#include "services/prior/edge_hypotheses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace sprout {
namespace {

using testing::UnorderedElementsAre;

// Level planes at the corners of a square, in two triangles.
struct Square {
  SeedSurface surface;
  std::vector<SeedTriangle> triangles{{0, 1, 2}, {1, 3, 2}};

  explicit Square(std::array<float, 4> disparities) {
    for (size_t i = 0; i < 4; ++i) {
      surface.planes.push_back(
          {.u = i % 2 == 0 ? 2.F : 12.F, .v = i < 2 ? 1.F : 11.F, .disparity = disparities[i]});
    }
  }

  std::vector<EdgeTriangle> Edges(double edge_px = 1) const {
    SeedNeighbours neighbours;
    neighbours.Find(surface.planes.size(), triangles);
    EdgeTriangleFinder finder;
    const auto edges = finder.Find(surface, triangles, neighbours, edge_px);
    return {edges.begin(), edges.end()};
  }

  EdgeHypotheses Hypotheses(cv::Size size = {16, 15}) const {
    EdgeHypotheses hypotheses;
    PaintEdgeHypotheses(Edges(), size, hypotheses);
    return hypotheses;
  }
};

TEST(EdgeTriangles, AreThoseWhoseSeedsLieOnTwoSurfaces) {
  EXPECT_EQ(Square({5, 6, 20, 20}).Edges().size(), 2U);
  EXPECT_EQ(Square({5, 5, 5, 20}).Edges().size(), 1U);
  EXPECT_EQ(Square({5, 5, 5, 20}).Edges(15.5).size(), 0U);
  EXPECT_EQ(Square({5, 5.5F, 5.2F, 5.9F}).Edges().size(), 0U);
  Square slanted({5, 6, 5, 6});  // one surface, though its seeds differ by a pixel
  for (LocalPlane& plane : slanted.surface.planes) plane.per_column = 0.1F;
  EXPECT_EQ(slanted.Edges().size(), 0U);
}

TEST(EdgeTriangles, KnowTheirSeedsAndThoseAround) {
  const std::vector<EdgeTriangle> edges = Square({5, 6, 20, 20}).Edges();
  EXPECT_EQ(edges[0].corners[2].v, 11);
  EXPECT_EQ(edges[0].corners[2].disparity(), 20);
  EXPECT_EQ(edges[1].corners[1].u, 12);
  EXPECT_THAT(edges[0].nearby(), UnorderedElementsAre(0, 1, 2, 3));
}

// A row of triangles: each seed is a neighbour of the next two.
TEST(EdgeTriangles, LookTwoStepsAroundAndNoFurther) {
  SeedSurface surface;
  std::vector<SeedTriangle> strip;
  for (int i = 0; i < 30; ++i) {
    surface.planes.push_back({.u = 5.F * static_cast<float>(i),
                              .v = i % 2 == 0 ? 0.F : 10.F,
                              .disparity = i < 15 ? 20.F : 5.F});
    if (i >= 2) strip.push_back({i - 2, i - 1, i});
  }
  SeedNeighbours neighbours;
  neighbours.Find(30, strip);
  EdgeTriangleFinder finder;
  const auto edges = finder.Find(surface, strip, neighbours, 1);
  ASSERT_EQ(edges.size(), 2U);
  EXPECT_THAT(edges[0].nearby(), UnorderedElementsAre(9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19));
}

TEST(EdgeTriangles, OfSeedsWithThousandsOfNeighboursKnowSome) {
  constexpr int kRim = 5000;
  SeedSurface surface;
  surface.planes.assign(1 + kRim, {.disparity = 5});
  surface.planes[0].disparity = 20;
  std::vector<SeedTriangle> fan;
  for (int i = 1; i < kRim; ++i) fan.push_back({0, i, i + 1});
  SeedNeighbours neighbours;
  neighbours.Find(surface.planes.size(), fan);
  EdgeTriangleFinder finder;
  const auto edges = finder.Find(surface, fan, neighbours, 1);
  ASSERT_EQ(edges.size(), fan.size());
  for (size_t i = 0; i < edges.size(); ++i) {
    EXPECT_EQ(edges[i].nearby().size(), EdgeTriangle::kMostSeeds);
    EXPECT_THAT(edges[i].nearby(), testing::IsSupersetOf(fan[i]));
  }
}

// As if the last seed were one that BorderExtender has added.
TEST(EdgeTriangles, WithACornerAtTheBorderKnowTheSeedsAroundTheOthers) {
  const Square square({5, 6, 20, 20});
  SeedNeighbours neighbours;
  neighbours.Find(3, std::vector<SeedTriangle>{{0, 1, 2}});
  EdgeTriangleFinder finder;
  const std::vector<SeedTriangle> triangles{{3, 2, 1}};
  const auto edges = finder.Find(square.surface, triangles, neighbours, 1);
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_THAT(edges[0].nearby(), UnorderedElementsAre(0, 1, 2));
}

// The second seed is far, but at the centre of the first triangle its plane is near.
TEST(EdgeTriangles, LeaveEachCornerOnOneSurface) {
  Square steep({5, 6, 20, 20});
  steep.surface.planes[1].per_row = 4;
  const EdgeTriangle edge = steep.Edges().front();
  EXPECT_EQ(edge.near.At({10, 0}), 20);
  EXPECT_EQ(edge.far.At({10, 0}), 6);
}

TEST(EdgeTriangles, ForgetTheFrameBefore) {
  Square large({5, 6, 20, 20});
  Square small({5, 6, 20, 20});
  small.triangles.pop_back();
  small.surface.planes.pop_back();
  EdgeTriangleFinder finder;
  for (const Square* square : {&large, &small}) {
    SeedNeighbours neighbours;
    neighbours.Find(square->surface.planes.size(), square->triangles);
    const auto edges = finder.Find(square->surface, square->triangles, neighbours, 1);
    EXPECT_EQ(edges.size(), square->triangles.size());
    EXPECT_EQ(edges[0].nearby().size(), square->surface.planes.size());
  }
}

TEST(EdgeTriangles, OfTheBorderKnowNone) {
  const Square square({5, 6, 20, 20});
  SeedNeighbours neighbours;
  neighbours.Find(0, {});
  EdgeTriangleFinder finder;
  for (const EdgeTriangle& edge : finder.Find(square.surface, square.triangles, neighbours, 1)) {
    EXPECT_TRUE(edge.nearby().empty());
    EXPECT_EQ(edge.far.At({0, 0}), edge.corners[0].disparity());
  }
}

TEST(PiecewiseSurface, IsThePlaneOfTheClosestSeedAllOverTheTriangle) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> place(-10, 20);
  std::uniform_real_distribution<float> number(0, 1);
  const PiecewiseSurface::Corners corners{cv::Point2f(0, 0), cv::Point2f(9, 1), cv::Point2f(2, 10)};
  for (int round = 0; round < 200; ++round) {
    std::vector<LocalPlane> planes;
    PiecewiseSurface surface;
    for (int i = 0; i < 8; ++i) {
      planes.push_back({place(random), place(random), 50, number(random), number(random)});
      surface.Add(planes.back(), {planes.back().u, planes.back().v}, corners);
    }
    for (int i = 0; i < 20; ++i) {
      float b = number(random);
      float c = number(random);
      if (b + c > 1) b = 1 - b, c = 1 - c;
      const cv::Point2f p = b * corners[1] + c * corners[2];
      const auto distance = [&](const LocalPlane& plane) {
        return std::hypot(plane.u - p.x, plane.v - p.y);
      };
      const auto closest = std::min_element(
          planes.begin(), planes.end(),
          [&](const auto& one, const auto& other) { return distance(one) < distance(other); });
      EXPECT_NEAR(surface.At(p), closest->At(p.x, p.y), 1e-3);
    }
  }
}

TEST(PiecewiseSurface, HasEightSeedsAtMost) {
  const PiecewiseSurface::Corners corners{cv::Point2f(0, 0), cv::Point2f(90, 0), cv::Point2f(0, 9)};
  PiecewiseSurface surface;
  for (int i = 0; i < 10; ++i) {
    const auto u = static_cast<float>(9 * i);
    surface.Add({.u = u, .v = 0, .disparity = u}, {u, 0}, corners);
  }
  EXPECT_EQ(surface.At({63, 0}), 63);
  EXPECT_EQ(surface.At({81, 0}), 63);
}

TEST(EdgeHypotheses, AreTheSurfacesOnBothSidesOfTheGap) {
  const EdgeHypotheses two = Square({5, 6, 20, 20}).Hypotheses();
  EXPECT_EQ(two.near.Px(2, 5), 20);
  EXPECT_EQ(two.far.Px(2, 1), 5);
  EXPECT_EQ(two.far.Px(12, 1), 6);
  EXPECT_EQ(two.far.Px(6, 2), 5);  // of the closer of its two seeds
  EXPECT_EQ(two.far.Px(8, 2), 6);
  EXPECT_EQ(two.edge(2, 3), 0);
  EXPECT_EQ(two.edge(10, 11), 1);
  EXPECT_FALSE(two.near.IsValid(1, 5));  // outside of the triangles
  EXPECT_FALSE(two.far.IsValid(5, 12));
}

// The second triangle's far seed is the closest one of the far surface in a part of the first.
TEST(EdgeHypotheses, FollowTheSeedsOfOtherTrianglesToo) {
  Square square({5, 20, 20, 7});
  square.surface.planes[3].u = square.surface.planes[3].v = 9;
  const EdgeHypotheses two = square.Hypotheses();
  EXPECT_EQ(two.edge(5, 6), 0);
  EXPECT_EQ(two.far.Px(6, 6), 7);
  EXPECT_EQ(two.far.Px(3, 2), 5);
  square.surface.planes[3].disparity = 40;  // of neither surface
  EXPECT_EQ(square.Hypotheses().far.Px(5, 5), 5);
  EXPECT_EQ(square.Hypotheses().near.Px(5, 5), 20);
}

TEST(EdgeHypotheses, AreNoneWhereSurfacesMeet) {
  Square crossing({5, 5, 7, 7});
  crossing.surface.planes[0].per_row = crossing.surface.planes[1].per_row = 0.4F;
  const EdgeHypotheses two = crossing.Hypotheses();  // in row 6
  EXPECT_TRUE(two.near.IsValid(3, 2));
  EXPECT_FALSE(two.near.IsValid(3, 6));
  EXPECT_TRUE(two.near.IsValid(3, 9));
}

TEST(EdgeHypotheses, NeverLieBeyondInfinity) {
  Square falling({1, 2, 20, 20});
  for (LocalPlane& plane : falling.surface.planes) plane.per_row = -3;
  const EdgeHypotheses hypotheses = falling.Hypotheses();
  ASSERT_GT(hypotheses.far.CountValid(), 0);
  for (const int16_t counts : hypotheses.far.counts()) {
    EXPECT_TRUE(counts >= 0 || counts == DisparityImage::kInvalid);
  }
}

TEST(EdgeHypotheses, ForgetTheFrameBefore) {
  EdgeHypotheses hypotheses = Square({5, 6, 20, 20}).Hypotheses();
  PaintEdgeHypotheses({}, {16, 15}, hypotheses);
  EXPECT_EQ(hypotheses.near.CountValid(), 0);
  EXPECT_EQ(hypotheses.far.CountValid(), 0);
}

TEST(EdgeHypotheses, StayInRangeWhenPlanesAreSteep) {
  Square steep({5, 6, 900, 1000});
  for (LocalPlane& plane : steep.surface.planes) plane.per_row = 500;
  const EdgeHypotheses two = steep.Hypotheses();
  EXPECT_GT(two.near.CountValid(), 50);
  EXPECT_EQ(two.near.CountValid(), two.far.CountValid());
  EXPECT_EQ(cv::countNonZero(two.near.counts() < two.far.counts()), 0);
}

}  // namespace
}  // namespace sprout
