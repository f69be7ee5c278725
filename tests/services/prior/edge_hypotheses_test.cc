// The two surfaces that the pixels of a triangle across an edge may lie on.
#include "services/prior/edge_hypotheses.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace sprout {
namespace {

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

  EdgeHypotheses Hypotheses(cv::Size size) const {
    EdgeHypotheses hypotheses;
    PaintEdgeHypotheses(surface, triangles, 1, size, hypotheses);
    return hypotheses;
  }
};

TEST(EdgeHypotheses, AreTheSurfacesOnBothSidesOfTheGap) {
  const EdgeHypotheses two = Square({5, 6, 20, 20}).Hypotheses({16, 15});
  EXPECT_EQ(two.near.Px(2, 5), 20);
  EXPECT_EQ(two.far.Px(2, 1), 5);
  EXPECT_EQ(two.far.Px(12, 1), 6);
  EXPECT_EQ(two.far.Px(6, 2), 5);  // of the closer of its two seeds
  EXPECT_EQ(two.far.Px(8, 2), 6);
  EXPECT_FALSE(two.near.IsValid(1, 5));  // outside of the triangles
  EXPECT_FALSE(two.far.IsValid(5, 12));
}

TEST(EdgeHypotheses, KnowTheSeedsAroundThem) {
  const Square square({5, 6, 20, 20});
  const EdgeHypotheses two = square.Hypotheses({16, 15});
  EXPECT_EQ(two.TriangleAt(3, 2), square.triangles[0]);
  EXPECT_EQ(two.TriangleAt(11, 10), square.triangles[1]);
}

TEST(EdgeHypotheses, AreNoneInLevelTrianglesAndWhereSurfacesMeet) {
  EXPECT_EQ(Square({5, 5.5F, 5.2F, 5.9F}).Hypotheses({16, 15}).near.CountValid(), 0);
  Square slanted({5, 6, 5, 6});  // one surface, though its seeds differ by a pixel
  for (LocalPlane& plane : slanted.surface.planes) plane.per_column = 0.1F;
  EXPECT_EQ(slanted.Hypotheses({16, 15}).near.CountValid(), 0);
}

TEST(EdgeHypotheses, NeverLieBeyondInfinity) {
  Square falling({1, 2, 20, 20});
  for (LocalPlane& plane : falling.surface.planes) plane.per_row = -3;
  const EdgeHypotheses hypotheses = falling.Hypotheses({16, 15});
  ASSERT_GT(hypotheses.far.CountValid(), 0);
  for (const int16_t counts : hypotheses.far.counts()) {
    EXPECT_TRUE(counts >= 0 || counts == DisparityImage::kInvalid);
  }
}

TEST(EdgeHypotheses, ForgetTheFrameBefore) {
  EdgeHypotheses hypotheses = Square({5, 6, 20, 20}).Hypotheses({16, 15});
  const Square level({5, 5, 5, 5});
  PaintEdgeHypotheses(level.surface, level.triangles, 1, {16, 15}, hypotheses);
  EXPECT_EQ(hypotheses.near.CountValid(), 0);
  EXPECT_EQ(hypotheses.far.CountValid(), 0);
}

TEST(EdgeHypotheses, StayInRangeWhenPlanesAreSteep) {
  Square steep({5, 6, 900, 1000});
  for (LocalPlane& plane : steep.surface.planes) plane.per_row = 500;
  const EdgeHypotheses two = steep.Hypotheses({16, 15});
  EXPECT_GT(two.near.CountValid(), 50);
  EXPECT_EQ(two.near.CountValid(), two.far.CountValid());
  EXPECT_EQ(cv::countNonZero(two.near.counts() < two.far.counts()), 0);
}

}  // namespace
}  // namespace sprout
