#include "services/refine/surface/range_steps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/common/core/centred.h"

namespace sprout::refine {
namespace {

// What is added to a point in the middle of a slant from 1 to 3 m whose depths come in steps.
double SigmaPx(double step_m) {
  RectifiedPair pair = CentredPair(640, 480, 500);
  pair.baseline_m = 0.1;
  TofImage tof{.depth_m = cv::Mat1f(60, 80), .amplitude = {}};
  std::vector<ProjectedPoint> points;
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 80; ++u) {
      const double depth_m = step_m * std::round((1 + (u + 80 * v) / 2400.0) / step_m);
      tof.depth_m(v, u) = static_cast<float>(depth_m);
      const auto column = static_cast<float>(8 * u);
      const auto disparity = static_cast<float>(500 * 0.1 / depth_m);
      points.push_back({u, v, {column, static_cast<float>(8 * v), column - disparity}});
    }
  }
  for (ProjectedPoint& point : points) point.seed.sigma_px = 0;
  AddStepSigma(pair, tof, points);
  return points[80 * 30].seed.sigma_px;
}

TEST(RangeSteps, AddWhatTheyErrAlike) {
  for (const double step_m : {0.2, 0.25}) {
    const double step_px = 500 * 0.1 * step_m / (2 * 2);
    EXPECT_NEAR(SigmaPx(step_m), std::sqrt((step_px * step_px - 1) / 12), 0.02);
  }
}

TEST(RangeSteps, AddNothingWhereTheyAreFine) {
  EXPECT_EQ(SigmaPx(0.05), 0) << "steps below a px";
  EXPECT_EQ(SigmaPx(1e-5), 0);
  EXPECT_EQ(SigmaPx(1), 0) << "three surfaces, each at its depth";
}

}  // namespace
}  // namespace sprout::refine
