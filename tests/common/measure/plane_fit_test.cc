#include "common/measure/plane_fit.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "tests/common/measure/flat_target.h"

namespace sprout {
namespace {

using testing::FlatTarget;
using testing::kNoDisparity;
using testing::TargetNoise;
using testing::TargetPair;

TEST(PlaneFit, IsExactWithoutNoise) {
  const RectifiedPair pair = TargetPair();
  const FlatTarget target{.distance_m = 1.3, .horizontal_deg = 20, .vertical_deg = -15};
  const auto fit = FitPlane(target.Disparity(pair)(cv::Rect(50, 40, 100, 80)), {50, 40});
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->inliers, 8000);
  EXPECT_EQ(fit->outliers, 0);
  for (const cv::Point p : {cv::Point(0, 0), {319, 0}, {160, 239}}) {
    EXPECT_NEAR(fit->plane.At(p.x, p.y), pair.DisparityFromDepth(target.DepthAt(pair, p.x, p.y)),
                1e-4);
  }
  const auto plane = PlaneInSpace(fit->plane, pair);
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->offset(), -1.3, 1e-6);
}

// The distance of a point of space from the plane, along the optical axis and in disparities: of
// other parameters (normal and distance), by another program.
struct SpaceResidual {
  Eigen::Vector3d ray;
  double disparity_px;
  double focal_baseline;
  double offset_px;

  template <typename T>
  bool operator()(const T* plane, T* residual) const {  // plane: normal / distance, 1/m
    const T inverse_depth = plane[0] * ray.x() + plane[1] * ray.y() + plane[2] * ray.z();
    residual[0] = focal_baseline * inverse_depth + offset_px - disparity_px;
    return true;
  }
};

Eigen::Vector3d CeresPlane(const cv::Mat1f& map, const RectifiedPair& pair,
                           const std::optional<PlaneFit>& only_inliers_of) {
  ceres::Problem problem;
  Eigen::Vector3d plane(0, 0, 1);
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      if (std::isnan(map(v, u))) continue;
      const PlaneFit* fit = only_inliers_of ? &*only_inliers_of : nullptr;
      if (fit != nullptr && std::abs(map(v, u) - fit->plane.At(u, v)) > fit->limit_px) continue;
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<SpaceResidual, 1, 3>(
              new SpaceResidual{{(u - pair.cx) / pair.focal_px, (v - pair.cy) / pair.focal_px, 1},
                                map(v, u),
                                pair.focal_px * pair.baseline_m,
                                pair.cx - pair.cx_right}),
          nullptr, plane.data());
    }
  }
  ceres::Solver::Options options;
  options.function_tolerance = options.parameter_tolerance = 1e-14;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return plane;
}

TEST(PlaneFit, AgreesWithAnIndependentFit) {
  const RectifiedPair pair = TargetPair();
  TargetNoise noise;
  cv::Mat1f map = noise.On(
      FlatTarget{.distance_m = 1.7, .horizontal_deg = -12, .vertical_deg = 5}.Disparity(pair), 0.2);
  for (float& d : map) {
    if (noise.Uniform() < 0.3) d = kNoDisparity;
    if (noise.Uniform() < 0.1) d += 9;
  }
  const auto fit = FitPlane(map, {0, 0});
  ASSERT_TRUE(fit);
  const auto plane = PlaneInSpace(fit->plane, pair);
  const Eigen::Vector3d ceres = CeresPlane(map, pair, fit);
  EXPECT_NEAR(-plane->offset(), 1 / ceres.norm(), 1e-7);
  EXPECT_LT((plane->normal() - ceres.normalized()).norm(), 1e-7);
}

TEST(PlaneFit, StandsNearlyHalfOfThePixelsElsewhere) {
  const RectifiedPair pair = TargetPair();
  TargetNoise noise;
  cv::Mat1f map = noise.On(FlatTarget{.horizontal_deg = 10}.Disparity(pair), 0.1);
  map(cv::Rect(0, 0, 128, 240)) += 15.0F;  // 40 % on a board before the wall
  const auto fit = FitPlane(map, {0, 0});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(static_cast<double>(fit->outliers), 128 * 240, 100);
  EXPECT_NEAR(PlaneInSpace(fit->plane, pair)->offset(), -1.5, 0.001);
}

TEST(PlaneFit, TakesDisparitiesOfWholePixels) {
  const RectifiedPair pair = TargetPair();
  cv::Mat1f map = FlatTarget{.horizontal_deg = 10}.Disparity(pair);
  for (float& d : map) d = std::round(d);
  const auto fit = FitPlane(map, {0, 0});
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->outliers, 0);
  EXPECT_NEAR(PlaneInSpace(fit->plane, pair)->offset(), -1.5, 0.002);
}

TEST(PlaneFit, IsNoneOfTooFewPixelsOrOfThoseOnALine) {
  cv::Mat1f map(240, 320, kNoDisparity);
  EXPECT_FALSE(FitPlane(map, {0, 0}));
  EXPECT_FALSE(FitPlane(cv::Mat1f(), {0, 0}));
  for (int u = 0; u < 320; ++u) map(100, u) = 90;
  EXPECT_FALSE(FitPlane(map, {0, 0}));
  map = cv::Mat1f(240, 320, kNoDisparity);
  for (int i = 0; i < 240; ++i) map(i, i) = 90;
  EXPECT_FALSE(FitPlane(map, {0, 0}));
  map = cv::Mat1f(8, 8, kNoDisparity);
  map(cv::Rect(0, 0, 7, 2)) = 90;
  EXPECT_FALSE(FitPlane(map, {0, 0}));
  map(cv::Rect(0, 0, 5, 3)) = 90;
  EXPECT_TRUE(FitPlane(map, {0, 0}));
}

TEST(PlaneFit, NoPlaneInSpaceBehindTheCameras) {
  const RectifiedPair pair = TargetPair();
  EXPECT_FALSE(PlaneInSpace({.du = 0, .dv = 0, .d0 = 3}, pair));   // at infinity
  EXPECT_FALSE(PlaneInSpace({.du = 0, .dv = 0, .d0 = -5}, pair));  // behind
  EXPECT_TRUE(PlaneInSpace({.du = 0, .dv = 0, .d0 = 4}, pair));
}

}  // namespace
}  // namespace sprout
