#include "services/refine/range/range_curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

namespace sprout::refine {
namespace {

const RectifiedPair kPair{.width = 1242, .height = 375, .focal_px = 721, .baseline_m = 0.54};

const RectifiedPair kCamera{.width = 465, .height = 370, .focal_px = 1247, .baseline_m = 0.16};

// Costs that are least, and so much less than elsewhere, at an offset of least_px.
void SetCosts(double least_px, double depth, RangeNode& node) {
  for (int k = 0; k < RangeRules::kLabels; ++k) {
    const double away = RangeRules::OffsetPx(k) - least_px;
    node.costs[static_cast<size_t>(k)] =
        static_cast<float>(0.8 - depth * std::exp(-away * away / 2));
  }
  node.distinctness = DistinctnessOf(node.costs);
}

// Nodes of a scan from 5 to 50 m whose depths are too large by error_m of them. Near ones show it
// clearly; far ones, where it is a part of a px, have little texture and disagree.
std::vector<RangeNode> NodesOffBy(const std::function<double(double)>& error_m) {
  constexpr int kNodes = 900;
  cv::RNG random(3);
  std::vector<RangeNode> nodes(kNodes);
  for (int i = 0; i < kNodes; ++i) {
    RangeNode& node = nodes[static_cast<size_t>(i)];
    node.cell = {i % 30, i / 30};
    const double depth_m = 5 * std::pow(10, double{random.uniform(0.0F, 1.0F)});
    node.disparity = kPair.DisparityFromDepth(depth_m);
    const double off_px = kPair.DisparityFromDepth(depth_m - error_m(depth_m)) - node.disparity;
    const double least = off_px + random.gaussian(depth_m > 10 ? 1.0 : 0.3);
    const double depth = depth_m > 10 ? 0.25 : 0.7;
    SetCosts(least, depth, node);
  }
  return nodes;
}

// The furthest that a knot lies from the true error, m.
double WorstOf(const RangeCurve& curve, double error_m) {
  double worst = 0;
  for (const RangeKnot& knot : curve.knots()) {
    worst = std::max(worst, std::abs(knot.error_m - error_m));
  }
  return worst;
}

TEST(RangeCurve, OfALidarIsDrawnNeitherToZeroNorFromKnotToKnot) {
  constexpr double kErrorM = 0.3;
  const std::vector<RangeNode> nodes = NodesOffBy([](double) { return kErrorM; });
  RangeCurve bent;
  bent.Estimate(nodes, kPair, /*stiff=*/false);
  RangeCurve stiff;
  stiff.Estimate(nodes, kPair, /*stiff=*/true);
  ASSERT_FALSE(bent.is_zero());
  ASSERT_FALSE(stiff.is_zero());
  EXPECT_GT(WorstOf(bent, kErrorM), 0.12);
  EXPECT_LT(WorstOf(stiff, kErrorM), 0.06);
}

// As with a focal length that is 8 % too long: at the far knots that is more than the candidates
// that near ones have.
TEST(RangeCurve, OfALidarMayBeAPartOfTheDepth) {
  RangeCurve curve;
  curve.Estimate(NodesOffBy([](double depth_m) { return 0.08 * depth_m; }), kPair, /*stiff=*/true);
  ASSERT_FALSE(curve.is_zero());
  for (const RangeKnot& knot : curve.knots()) {
    EXPECT_NEAR(knot.error_m, 0.08 * knot.depth_m, 0.005 * knot.depth_m);
  }
}

// Nodes of a camera whose depths are all 20 mm too large: a textured scene of 1.4 to 1.8 m, and a
// wall behind it whose texture is its noise.
std::vector<RangeNode> NodesBeforeWall(double wall_m) {
  constexpr int kNodes = 1200;
  constexpr double kErrorM = 0.02;
  cv::RNG random(5);
  std::vector<RangeNode> nodes(kNodes);
  for (int i = 0; i < kNodes; ++i) {
    RangeNode& node = nodes[static_cast<size_t>(i)];
    node.cell = {i % 40, i / 40};
    const bool is_wall = i % 2 == 1;
    const double depth_m = is_wall ? wall_m + 0.02 * random.uniform(0.0F, 1.0F)
                                   : 1.4 + 0.4 * random.uniform(0.0F, 1.0F);
    node.disparity = kCamera.DisparityFromDepth(depth_m);
    const double off_px = kCamera.DisparityFromDepth(depth_m - kErrorM) - node.disparity;
    const double least = is_wall ? random.uniform(-6.0F, 6.0F) : off_px + random.gaussian(0.3);
    const double depth = is_wall ? 0.15 : 0.7;
    SetCosts(least, depth, node);
  }
  return nodes;
}

double ErrorOfWall(double wall_m) {
  RangeCurve curve;
  curve.Estimate(NodesBeforeWall(wall_m), kCamera, /*stiff=*/false);
  return curve.knots().back().error_m;
}

TEST(RangeCurve, OfAWallWithoutTextureFollowsWhatIsNotFarBeforeIt) {
  EXPECT_GT(ErrorOfWall(1.9), 0.008);
  EXPECT_NEAR(ErrorOfWall(2.6), 0.02, 0.01);
}

// A wall whose texture is a tenth of its noise, and is off the other way than what stands before
// it.
TEST(RangeCurve, OfAWallWithWeakTextureIsSeenInManyNodes) {
  constexpr double kWallM = 2.1;
  constexpr double kErrorM = -0.015;
  std::vector<RangeNode> nodes = NodesBeforeWall(kWallM);
  cv::RNG random(7);
  for (RangeNode& node : nodes) {
    const double depth_m = kCamera.DepthFromDisparity(node.disparity);
    if (depth_m < kWallM - 0.01) continue;
    const double off_px = kCamera.DisparityFromDepth(depth_m - kErrorM) - node.disparity;
    for (int k = 0; k < RangeRules::kLabels; ++k) {
      const double away = RangeRules::OffsetPx(k) - off_px;
      node.costs[static_cast<size_t>(k)] =
          static_cast<float>(0.97 - 0.1 * std::exp(-away * away / 2) + random.gaussian(0.14));
    }
    node.distinctness = DistinctnessOf(node.costs);
  }
  RangeCurve curve;
  curve.Estimate(nodes, kCamera, /*stiff=*/false);
  ASSERT_FALSE(curve.is_zero());
  EXPECT_NEAR(curve.knots().front().error_m, 0.02, 0.003);
  EXPECT_NEAR(curve.knots().back().error_m, kErrorM, 0.006);
}

TEST(RangeCurve, IsAboutAsSureOfAWallWithoutTextureAsOfWhatIsCloseBeforeIt) {
  const auto sigma_of = [](double wall_m, double error_m) {
    RangeCurve curve;
    curve.Estimate(NodesBeforeWall(wall_m), kCamera, /*stiff=*/false);
    if (error_m > 0) curve.BoundSigmas(error_m);
    return curve.knots().back().sigma_m;
  };
  EXPECT_GT(sigma_of(1.85, 0), 0.01);
  EXPECT_LT(sigma_of(1.85, 0.01), 0.004) << "0.1 m behind the last knot with texture";
  EXPECT_GT(sigma_of(1.85, 0.04), 0.006) << "of a sensor that is less sure";
  EXPECT_GT(sigma_of(2.6, 0.01), 0.01);
}

}  // namespace
}  // namespace sprout::refine
