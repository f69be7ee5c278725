// The parts of method EDGES: hypotheses, judge, and the walk from coarse to fine.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "services/prior/edges.h"
#include "services/prior/seed_spreading.h"

namespace sprout {
namespace {

constexpr int kOne = DisparityImage::kCountsPerPixel;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

cv::Size HalfOf(cv::Size size) { return {(size.width + 1) / 2, (size.height + 1) / 2}; }

DisparityImage ConstantMap(cv::Size size, int counts) {
  return DisparityImage(cv::Mat1s(size, static_cast<int16_t>(counts)));
}

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
  EXPECT_NEAR(two.far.Px(5, 1), 5.3, 0.05);  // along the line between its seeds
  EXPECT_NEAR(two.far.Px(5, 4), 5.3, 0.05);  // and across
  EXPECT_FALSE(two.near.IsValid(1, 5));      // outside of the triangles
  EXPECT_FALSE(two.far.IsValid(5, 12));
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

// A pair in which every left pixel has one disparity, and two hypotheses of which one is right.
struct Pair {
  Pair(cv::Size size, int disparity)
      : evidence{.left_bgr = cv::Mat3b(size),
                 .left_grey = cv::Mat1b(size),
                 .right_grey = cv::Mat1b(size, uint8_t{0}),
                 .half_bgr = cv::Mat3b(HalfOf(size), cv::Vec3b(90, 90, 90)),
                 .spread_px = cv::Mat1f(HalfOf(size), kNone),
                 .spread_weight = 0.6} {
    std::mt19937 random(1);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const auto grey = static_cast<uint8_t>(random() % 256);
        evidence.left_grey(v, u) = grey;
        evidence.left_bgr(v, u) = {90, 90, 90};
        if (u >= disparity) evidence.right_grey(v, u - disparity) = grey;
      }
    }
  }
  EdgeEvidence evidence;
};

TEST(EdgeJudge, FindsTheDisparityThatTheImagesHave) {
  const cv::Size size(51, 33);
  for (const int truth : {12, 3}) {
    const Pair pair(size, truth);
    const EdgeJudge judge(pair.evidence);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 12; u < size.width; ++u) {
        EXPECT_EQ(judge.IsNear(u, v, 12 * kOne, 3 * kOne), truth == 12) << u << ", " << v;
      }
    }
  }
}

TEST(EdgeJudge, HoldsNothingOfHypothesesThatLeaveTheRightImage) {
  const cv::Size size(51, 33);
  const Pair pair(size, 3);
  const EdgeJudge judge(pair.evidence);
  for (int u = 3; u < size.width; ++u) {
    EXPECT_FALSE(judge.IsNear(u, 0, 1023 * kOne, 3 * kOne));
    EXPECT_TRUE(judge.IsNear(u, 32, 3 * kOne, -1023 * kOne));
    EXPECT_FALSE(judge.IsNear(u, 16, 1023 * kOne, -1023 * kOne));  // neither: the far one
  }
}

TEST(EdgeJudge, AsksTheSpreadSeedsWhereThereIsNoTexture) {
  const cv::Size size(51, 33);
  Pair pair(size, 3);
  pair.evidence.left_grey = 90;
  pair.evidence.right_grey = 90;
  for (const float spread_px : {11.F, 4.F}) {
    pair.evidence.spread_px = spread_px;
    EXPECT_EQ(EdgeJudge(pair.evidence).IsNear(50, 32, 12 * kOne, 3 * kOne), spread_px > 8);
  }
}

TEST(EdgeJudge, AsksThoseOnItsOwnSideOfAnEdgeInColour) {
  const cv::Size size(8, 8);  // red from column 3 on: the second column of the half image mixes
  Pair pair(size, 0);
  pair.evidence.left_grey = 90;
  pair.evidence.right_grey = 90;
  pair.evidence.spread_weight = 100;  // near disparities leave the right image
  pair.evidence.left_bgr.colRange(3, 8) = cv::Vec3b(90, 90, 250);
  cv::Mat none;
  HalveSize(pair.evidence.left_bgr, none, pair.evidence.half_bgr);
  pair.evidence.spread_px.colRange(0, 1) = 12;
  pair.evidence.spread_px.colRange(1, 2) = 7.5F;
  pair.evidence.spread_px.colRange(2, 4) = 3;
  const EdgeJudge judge(pair.evidence);
  for (int u = 0; u < size.width; ++u) {
    EXPECT_EQ(judge.IsNear(u, 5, 12 * kOne, 3 * kOne), u < 3) << u;
  }
}

TEST(ResolveEdges, FindsTheEdgeToThePixelAndLeavesTheRest) {
  // Odd sizes, and one for which the coarse grid has no cell at all.
  for (const cv::Size size : {cv::Size(61, 43), cv::Size(62, 42), cv::Size(3, 2), cv::Size(1, 1)}) {
    const int edge = size.width / 2;
    EdgeEvidence evidence = Pair(size, 0).evidence;
    evidence.left_grey = 90;
    evidence.right_grey = 90;
    evidence.spread_weight = 100;  // near disparities leave the right image
    for (int x = 0; x < evidence.spread_px.cols; ++x) {
      evidence.spread_px.col(x) = 2 * x < edge ? 12.F : 3.F;
    }
    EdgeHypotheses hypotheses{ConstantMap(size, 12 * kOne), ConstantMap(size, 3 * kOne), {}};
    const int undisputed = size.height > 4 ? 0 : -1;  // row
    if (undisputed == 0) hypotheses.near.counts().row(0) = DisparityImage::kInvalid;
    DisparityImage prior = ConstantMap(size, 7 * kOne);
    ResolveEdges(hypotheses, EdgeJudge(evidence), prior);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const float expected = v == undisputed ? 7.F : (u / 2 * 2 < edge ? 12.F : 3.F);
        ASSERT_EQ(prior.Px(u, v), expected) << u << ", " << v << " of " << size;
      }
    }
  }
}

TEST(SeedSpreading, CoversOddImagesAtHalfSize) {
  for (const cv::Size size : {cv::Size(31, 21), cv::Size(30, 20), cv::Size(5, 1), cv::Size(1, 1)}) {
    const std::vector<Seed> seeds = {{.u = 0, .v = 0, .u_right = -7}};
    cv::Mat even;
    cv::Mat half;
    HalveSize(cv::Mat3b(size, cv::Vec3b()), even, half);
    const cv::Mat1f spread = SeedSpreader().SpreadAtHalfSize(seeds, half, 10, 3);
    EXPECT_EQ(spread.size(), HalfOf(size));
    EXPECT_FLOAT_EQ(spread(0, 0), 7);
  }
}

}  // namespace
}  // namespace sprout
