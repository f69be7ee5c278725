#include "common/measure/edge_width.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/core/quantile.h"
#include "tests/common/measure/flat_target.h"

namespace sprout {
namespace {

using testing::kNoDisparity;

// From 30 to 50 px of disparity around column 40, as `share` of the distance from there tells.
template <typename Share>
cv::Mat1f Edge(const Share& share) {
  cv::Mat1f map(60, 80);
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) map(v, u) = static_cast<float>(30 + 20 * share(u - 40.3));
  }
  return map;
}

cv::Mat1f Ramp(double width_px) {
  return Edge([&](double x) { return std::clamp(x / width_px + 0.5, 0.0, 1.0); });
}

float MedianWidth(const cv::Mat1f& map) {
  std::vector<float> px = MeasureEdge(map).px;
  return px.empty() ? 0 : Median(px);
}

TEST(EdgeWidth, AStepBetweenTwoPixelsIsTheLeast) {
  const cv::Mat1f step = Edge([](double x) { return x > 0 ? 1 : 0; });
  EXPECT_EQ(MeasureEdge(step).px.size(), 60);
  EXPECT_EQ(MeasureEdge(step).without_edge, 0);
  EXPECT_NEAR(MedianWidth(step), 0.8, 1e-4);
}

TEST(EdgeWidth, IsThatOfTheBlurThatWasPutIn) {
  for (const double width_px : {10.0, 15.0, 20.0}) {
    EXPECT_NEAR(MedianWidth(Ramp(width_px)), 0.8 * width_px, 0.02 * 0.8 * width_px);
  }
  for (const double sigma_px : {3.0, 4.5, 6.0}) {
    const cv::Mat1f blurred =
        Edge([&](double x) { return 0.5 + 0.5 * std::erf(x / sigma_px / std::sqrt(2)); });
    // From 10 to 90 % of a normal distribution.
    EXPECT_NEAR(MedianWidth(blurred), 2.5631 * sigma_px, 0.02 * 2.5631 * sigma_px);
  }
}

TEST(EdgeWidth, OfANarrowEdgeTheGridOfPixelsAddsHalfAPixelAtMost) {
  for (const double width_px : {2.0, 3.0, 4.0, 6.0}) {
    EXPECT_NEAR(MedianWidth(Ramp(width_px)), 0.8 * width_px + 0.25, 0.25) << width_px;
  }
}

TEST(EdgeWidth, IsTheSameFarSideLeftOrRightAndAlongTheRows) {
  const cv::Mat1f ramp = Ramp(10);
  cv::Mat1f mirrored;
  cv::flip(ramp, mirrored, 1);
  cv::Mat1f turned;
  cv::transpose(ramp, turned);
  EXPECT_NEAR(MedianWidth(mirrored), 8, 0.16);
  EXPECT_NEAR(MedianWidth(turned), 8, 0.16);
  EXPECT_EQ(MeasureEdge(turned).px.size(), 60);
}

TEST(EdgeWidth, NoiseOnEitherSideDoesNotWidenIt) {
  testing::TargetNoise noise;
  // 7 % of the step, so that many pixels beside the edge are beyond 10 %.
  EXPECT_NEAR(MedianWidth(noise.On(Ramp(10), 1.4)), 8, 0.6);
}

TEST(EdgeWidth, AHoleInTheEdgeIsPartOfIt) {
  cv::Mat1f step = Edge([](double x) { return x > 0 ? 1 : 0; });
  step(cv::Rect(41, 0, 4, 60)) = kNoDisparity;
  EXPECT_NEAR(MedianWidth(step), 0.8 * 5, 1e-4);
}

TEST(EdgeWidth, LinesWithoutAnEdgeAreCounted) {
  cv::Mat1f map = Ramp(4);
  map.rowRange(0, 10) = 30;
  map(cv::Rect(60, 50, 20, 10)) = kNoDisparity;
  EXPECT_EQ(MeasureEdge(map).px.size(), 40);
  EXPECT_EQ(MeasureEdge(map).without_edge, 20);
  EXPECT_TRUE(MeasureEdge(cv::Mat1f(60, 80, 30.0F)).px.empty());
  EXPECT_TRUE(MeasureEdge(cv::Mat1f(60, 80, kNoDisparity)).px.empty());
  EXPECT_EQ(MeasureEdge(cv::Mat1f()).without_edge, 0);
}

}  // namespace
}  // namespace sprout
