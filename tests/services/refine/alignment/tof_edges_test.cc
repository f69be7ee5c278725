#include "services/refine/alignment/tof_edges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/common/core/centred.h"

namespace sprout::refine {
namespace {

constexpr double kNearPx = 40;
constexpr double kFarPx = 20;

// A ToF camera of 40×30 pixels in the left camera's place, a ToF pixel every 10 px.
Rig EdgeRig() { return {CentredPair(400, 300, 500), CentredTof(40, 30, 50)}; }

float Depth(double disparity_px) {
  return static_cast<float>(EdgeRig().pair.DepthFromDisparity(disparity_px));
}

// A near surface in the columns [first, end) of the ToF image.
TofImage Strip(int first, int end) {
  TofImage tof{.depth_m = cv::Mat1f(30, 40, Depth(kFarPx)), .amplitude = cv::Mat1f(30, 40, 100.F)};
  tof.depth_m.colRange(first, end) = Depth(kNearPx);
  return tof;
}

std::vector<TofEdge> Find(const TofImage& tof, double least_px = 5) {
  const TofProjector projector(EdgeRig());
  int behind = 0;
  TofEdgeFinder finder;
  const auto edges = finder.Find(projector.Project(tof, behind), tof, projector, least_px);
  return {edges.begin(), edges.end()};
}

TEST(TofEdgeFinder, FindsWhereANearSurfaceEndsOnBothSides) {
  const std::vector<TofEdge> edges = Find(Strip(10, 20));
  ASSERT_FALSE(edges.empty());
  int left = 0;
  for (const TofEdge& edge : edges) {
    const bool is_left = edge.normal.x() < 0;
    left += is_left;
    // Half way between the ToF pixels 9 and 10, and 19 and 20.
    EXPECT_NEAR(edge.left.x(), is_left ? 95 : 195, 1e-3);
    EXPECT_NEAR(std::abs(edge.normal.x()), 1, 0.01);
    EXPECT_NEAR(edge.near_px, kNearPx, 1e-3);
    EXPECT_NEAR(edge.far_px, kFarPx, 1e-3);
    EXPECT_NEAR(edge.near_slope, 0, 1e-6);
  }
  EXPECT_EQ(edges.size(), 60u);
  EXPECT_EQ(left, 30);
}

TEST(TofEdgeFinder, ReadsTheEndOffAMixedPixelByTheLightOfBothSurfaces) {
  for (const double share : {0.2, 0.5, 0.9}) {
    TofImage tof = Strip(10, 20);
    constexpr double kNearLight = 150;
    constexpr double kFarLight = 50;
    tof.amplitude = kFarLight;
    tof.amplitude.colRange(10, 20) = kNearLight;
    const double near = share * kNearLight;
    const double far = (1 - share) * kFarLight;
    tof.depth_m.col(20) =
        static_cast<float>((near * Depth(kNearPx) + far * Depth(kFarPx)) / (near + far));
    int seen = 0;
    for (const TofEdge& edge : Find(tof)) {
      if (edge.normal.x() < 0) continue;
      EXPECT_NEAR(edge.left.x(), 195 + 10 * share, 0.05);
      ++seen;
    }
    EXPECT_EQ(seen, 30) << share;
  }
}

TEST(TofEdgeFinder, SurvivesNegativeAmplitudes) {
  // Light of both signs that nearly cancels would put the end far outside the image.
  TofImage tof = Strip(10, 20);
  tof.amplitude = 1.F;
  tof.amplitude.colRange(10, 20) = -1.F;
  const double middle = (double{Depth(kNearPx)} + Depth(kFarPx)) / 2;
  for (const double off_m : {-1e-3, -1e-4, 1e-4, 1e-3}) {
    tof.depth_m.col(20) = static_cast<float>(middle + off_m);
    for (const TofEdge& edge : Find(tof)) {
      EXPECT_GE(edge.left.x(), 0);
      EXPECT_LE(edge.left.x(), 400);
    }
  }
}

TEST(TofEdgeFinder, ASlantIsNoEdge) {
  TofImage tof = Strip(0, 0);
  for (int u = 0; u < 40; ++u) tof.depth_m.col(u) = Depth(20.0 + 1.5 * u);
  EXPECT_TRUE(Find(tof, 3).empty());
}

TEST(TofEdgeFinder, SurfacesGoOnWithTheirSlopes) {
  TofImage tof = Strip(0, 0);
  for (int u = 0; u < 40; ++u) tof.depth_m.col(u) = Depth(u < 20 ? 50 - 0.5 * u : 20 + 0.2 * u);
  const std::vector<TofEdge> edges = Find(tof);
  ASSERT_EQ(edges.size(), 30u);
  EXPECT_NEAR(edges[0].near_slope, -0.05, 1e-4);  // px a px
  EXPECT_NEAR(edges[0].far_slope, 0.02, 1e-4);
  EXPECT_NEAR(edges[0].near_px, 50 - 0.5 * 19.5, 0.01);
  EXPECT_NEAR(edges[0].far_px, 20 + 0.2 * 19.5, 0.01);
}

TEST(TofEdgeFinder, ATurnOfTheCameraMovesEdgesAlongTheirNormals) {
  for (const TofEdge& edge : Find(Strip(10, 20))) {
    EXPECT_NEAR(edge.motion.x(), edge.normal.x(), 0.06);  // 1 + x²
    EXPECT_NEAR(edge.motion.y(), 0, 0.06);
  }
}

TEST(TofEdgeFinder, NeitherHolesNorMissingReturnsAreEdges) {
  TofImage tof = Strip(10, 20);
  tof.depth_m.col(20) = std::numeric_limits<float>::quiet_NaN();
  for (const TofEdge& edge : Find(tof)) EXPECT_LT(edge.normal.x(), 0);
  tof.depth_m = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(Find(tof).empty());
}

}  // namespace
}  // namespace sprout::refine
