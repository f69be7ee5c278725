#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <random>

#include "common/geometry/projection.h"

namespace sprout {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

// A wide ToF camera with real distortion, turned and shifted against the left camera.
Rig WideRig() {
  Rig rig;
  rig.pair = {.width = 1280,
              .height = 960,
              .focal_px = 900,
              .cx = 650,
              .cy = 470,
              .cx_right = 630,
              .baseline_m = 0.12};
  rig.tof = {.width = 64,
             .height = 48,
             .fx = 60,
             .fy = 61,
             .cx = 31,
             .cy = 24.5,
             .distortion = {-0.28, 0.09, 0.0011, -0.0007, -0.012}};
  rig.tof.left_from_tof_rotation =
      Eigen::AngleAxisd(0.1, Eigen::Vector3d(0.3, -0.8, 0.2).normalized());
  rig.tof.left_from_tof_translation_m = {0.05, -0.03, 0.02};
  return rig;
}

// A camera that looks along the left one: pixel (1, 0) looks straight ahead, (0, 0) 45° to the
// left.
Rig SimpleRig() {
  Rig rig;
  rig.pair = {.width = 100,
              .height = 80,
              .focal_px = 50,
              .cx = 40,
              .cy = 30,
              .cx_right = 40,
              .baseline_m = 0.2};
  rig.tof = {.width = 3, .height = 2, .fx = 1, .fy = 1, .cx = 1, .cy = 0};
  return rig;
}

// Brown's model by its formula (OpenCV's documentation of calib3d), independent of its code.
cv::Point2d PixelOfRay(const TofCamera& tof, const Eigen::Vector3d& ray) {
  const auto [k1, k2, p1, p2, k3] = tof.distortion;
  const double x = ray.x() / ray.z();
  const double y = ray.y() / ray.z();
  const double r2 = x * x + y * y;
  const double radial = 1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
  const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return {tof.fx * xd + tof.cx, tof.fy * yd + tof.cy};
}

TofImage Flat(const TofCamera& tof, float depth_m) {
  return {.depth_m = cv::Mat1f(tof.height, tof.width, depth_m), .amplitude = {}};
}

TEST(TofProjector, RaysDistortBackToTheirPixel) {
  const Rig rig = WideRig();
  const TofProjector projector(rig);
  for (int v = 0; v < rig.tof.height; ++v) {
    for (int u = 0; u < rig.tof.width; ++u) {
      const Eigen::Vector3d& ray = projector.ray(u, v);
      EXPECT_EQ(ray.z(), 1.0);
      const cv::Point2d pixel = PixelOfRay(rig.tof, ray);
      ASSERT_NEAR(pixel.x, u, 1e-6) << "at " << u << ", " << v;
      ASSERT_NEAR(pixel.y, v, 1e-6) << "at " << u << ", " << v;
    }
  }
}

TEST(TofProjector, RaysPassThroughPointsThatOpenCvProjectsToTheirPixel) {
  const Rig rig = WideRig();
  const TofProjector projector(rig);
  const cv::Matx33d camera(rig.tof.fx, 0, rig.tof.cx, 0, rig.tof.fy, rig.tof.cy, 0, 0, 1);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> depth(0.2, 7);
  std::vector<cv::Point3d> points;
  for (int v = 0; v < rig.tof.height; v += 3) {
    for (int u = 0; u < rig.tof.width; u += 3) {
      const Eigen::Vector3d point = depth(random) * projector.ray(u, v);
      points.emplace_back(point.x(), point.y(), point.z());
    }
  }
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), camera, rig.tof.distortion, pixels);
  size_t i = 0;
  for (int v = 0; v < rig.tof.height; v += 3) {
    for (int u = 0; u < rig.tof.width; u += 3, ++i) {
      EXPECT_NEAR(pixels[i].x, u, 1e-6);
      EXPECT_NEAR(pixels[i].y, v, 1e-6);
    }
  }
}

TEST(TofProjector, AgreesWithOpenCvOnRotationTranslationAndDistortion) {
  const Rig rig = WideRig();
  const TofProjector projector(rig);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> depth(0.5F, 7);
  TofImage tof = Flat(rig.tof, 0);
  for (float& value : tof.depth_m) value = depth(random);

  int behind = -1;
  const std::vector<ProjectedPoint> projected = projector.Project(tof, behind);
  EXPECT_EQ(behind, 0);
  ASSERT_EQ(projected.size(), tof.depth_m.total());
  for (const ProjectedPoint& p : projected) {
    EXPECT_EQ(cv::Point(p.seed.tof_u, p.seed.tof_v), cv::Point(p.tof_u, p.tof_v));
    EXPECT_EQ(p.seed.origin, SeedOrigin::kTof);
  }

  // From the point back into the ToF camera, by OpenCV: tof_from_left is the inverse pose.
  const Eigen::Quaterniond rotation = rig.tof.left_from_tof_rotation.conjugate();
  const Eigen::Vector3d translation = -(rotation * rig.tof.left_from_tof_translation_m);
  const Eigen::AngleAxisd axis(rotation);
  const Eigen::Vector3d rvec = axis.angle() * axis.axis();
  const cv::Matx33d camera(rig.tof.fx, 0, rig.tof.cx, 0, rig.tof.fy, rig.tof.cy, 0, 0, 1);
  std::vector<cv::Point3d> points;
  for (const ProjectedPoint& p : projected) {
    const Eigen::Vector3d point = PointFromSeed(rig.pair, p.seed);
    points.emplace_back(point.x(), point.y(), point.z());
  }
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(points, cv::Vec3d(rvec.x(), rvec.y(), rvec.z()),
                    cv::Vec3d(translation.x(), translation.y(), translation.z()), camera,
                    rig.tof.distortion, pixels);
  for (size_t i = 0; i < projected.size(); ++i) {
    // Row by row; the seeds are float, hence the tolerance.
    ASSERT_EQ(projected[i].tof_u, static_cast<int>(i) % rig.tof.width);
    ASSERT_EQ(projected[i].tof_v, static_cast<int>(i) / rig.tof.width);
    ASSERT_NEAR(pixels[i].x, projected[i].tof_u, 2e-3);
    ASSERT_NEAR(pixels[i].y, projected[i].tof_v, 2e-3);
  }
}

TEST(TofProjector, HasNoPointsWithoutATofCamera) {
  int behind = 1;
  EXPECT_TRUE(TofProjector({.pair = {}, .tof = {}}).Project({}, behind).empty());
  EXPECT_EQ(behind, 0);
}

TEST(TofProjector, MatchesAnExampleByHand) {
  Rig rig = SimpleRig();
  // A quarter turn about the viewing axis: (x, y, z) of the ToF camera is (−y, x, z) of the left.
  rig.tof.left_from_tof_rotation = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
  rig.tof.left_from_tof_translation_m = {0.1, 0.2, 1.0};
  TofImage tof = Flat(rig.tof, kNan);
  tof.depth_m(1, 2) = 4;  // ray (1, 1, 1): point (4, 4, 4), in the left frame (−3.9, 4.2, 5)
  int behind = -1;
  const std::vector<ProjectedPoint> projected = TofProjector(rig).Project(tof, behind);
  ASSERT_EQ(projected.size(), 1U);
  EXPECT_EQ(projected[0].tof_u, 2);
  EXPECT_EQ(projected[0].tof_v, 1);
  EXPECT_FLOAT_EQ(projected[0].seed.u, 40 - 39);
  EXPECT_FLOAT_EQ(projected[0].seed.v, 30 + 42);
  EXPECT_FLOAT_EQ(projected[0].seed.u_right, 40 - 41);
  EXPECT_EQ(behind, 0);
}

TEST(TofProjector, IgnoresPixelsWithoutAReturn) {
  const Rig rig = SimpleRig();
  TofImage tof = Flat(rig.tof, 0);
  tof.depth_m(0, 0) = kNan;
  tof.depth_m(0, 1) = kInf;
  tof.depth_m(0, 2) = -1;
  tof.depth_m(1, 0) = -kInf;
  tof.depth_m(1, 2) = 10'001;  // beyond kMaxTofDepthM
  tof.depth_m(1, 1) = 2;
  int behind = -1;
  const std::vector<ProjectedPoint> projected = TofProjector(rig).Project(tof, behind);
  ASSERT_EQ(projected.size(), 1U);
  EXPECT_EQ(projected[0].tof_u, 1);
  EXPECT_EQ(projected[0].tof_v, 1);
  EXPECT_EQ(behind, 0);
}

TEST(TofProjector, CountsPointsBehindThePair) {
  Rig rig = SimpleRig();
  rig.tof.left_from_tof_translation_m = {0, 0, -2};
  TofImage tof = Flat(rig.tof, 1);  // z = −1
  tof.depth_m(0, 0) = 2;            // z = 0: no projection either
  tof.depth_m(0, 1) = 3;            // z = 1
  tof.depth_m(0, 2) = kNan;         // no return: neither seen nor behind
  int behind = -1;
  const std::vector<ProjectedPoint> projected = TofProjector(rig).Project(tof, behind);
  ASSERT_EQ(projected.size(), 1U);
  EXPECT_EQ(projected[0].tof_u, 1);
  EXPECT_EQ(projected[0].tof_v, 0);
  EXPECT_EQ(behind, 4);
}

TEST(TofProjector, KeepsPointsThatFallOutsideTheImages) {
  const Rig rig = SimpleRig();
  int behind = -1;
  const auto projected = TofProjector(rig).Project(Flat(rig.tof, 0.1F), behind);
  ASSERT_EQ(projected.size(), 6U);
  EXPECT_LT(projected[0].seed.u_right, 0);
}

}  // namespace
}  // namespace sprout
