#include "common/geometry/projection.h"

#include <gtest/gtest.h>

#include <random>

namespace sprout {
namespace {

RectifiedPair MakePair(double cx, double cx_right) {
  return {.width = 1280,
          .height = 960,
          .focal_px = 1000,
          .cx = cx,
          .cy = 480,
          .cx_right = cx_right,
          .baseline_m = 0.2};
}

TEST(ProjectToPair, MatchesAnExampleByHand) {
  // f = 1000, b = 0.2, z = 4: disparity f·b/z + cx − cx' = 50 + 640 − 600.
  const Seed seed = ProjectToPair(MakePair(640, 600), {1.0, -0.5, 4.0});
  EXPECT_FLOAT_EQ(seed.u, 640 + 250);
  EXPECT_FLOAT_EQ(seed.v, 480 - 125);
  EXPECT_FLOAT_EQ(seed.u_right, 600 + 200);
  EXPECT_FLOAT_EQ(seed.disparity(), 90);
}

TEST(PointFromSeed, MatchesAnExampleByHand) {
  const Eigen::Vector3d point =
      PointFromSeed(MakePair(640, 600), {.u = 890, .v = 355, .u_right = 800});
  EXPECT_NEAR((point - Eigen::Vector3d(1.0, -0.5, 4.0)).norm(), 0, 1e-12);
}

TEST(PointAt, IsWhatAPixelOfAMapStandsFor) {
  // Column 800, row 380, 90 px: z = f·b / (90 + 600 − 640) = 4.
  DisparityImage map(cv::Mat1s(960, 1280, DisparityImage::kInvalid));
  map.counts()(380, 800) = 90 * DisparityImage::kCountsPerPixel;
  const Eigen::Vector3d point = PointAt(MakePair(640, 600), map, 800, 380);
  EXPECT_NEAR((point - Eigen::Vector3d(0.64, -0.4, 4.0)).norm(), 0, 1e-12);
}

TEST(PointFromSeed, InvertsProjectToPairForAnyPointAndPrincipalPoints) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> column(-1, 1);
  std::uniform_real_distribution<double> depth(0.3, 8);
  std::uniform_real_distribution<double> centre(400, 900);
  for (int i = 0; i < 5000; ++i) {
    const RectifiedPair pair = MakePair(centre(random), centre(random));
    const double z = depth(random);
    const Eigen::Vector3d point(column(random) * z, column(random) * z, z);
    const Seed seed = ProjectToPair(pair, point);
    const Eigen::Vector3d back = PointFromSeed(pair, seed);
    // Seeds are float: at most 2^-13 px each at columns beyond 1024 (here up to 1900); a depth
    // error dz = z²/(f·b)·dd.
    const double bound = 4e-4 * z * z / (pair.focal_px * pair.baseline_m) + 1e-6 * z;
    EXPECT_LT((back - point).norm(), 2 * bound) << "point " << point.transpose();
    EXPECT_NEAR(seed.disparity(), pair.DisparityFromDepth(z), 4e-4);
  }
}

TEST(RectifiedPair, DepthAndDisparityAreInverse) {
  for (const double cx_right : {640.0, 600.0, 700.5}) {
    const RectifiedPair pair = MakePair(640, cx_right);
    for (const double depth_m : {0.1, 0.5, 1.0, 3.75, 100.0}) {
      const double disparity_px = pair.DisparityFromDepth(depth_m);
      EXPECT_NEAR(pair.DepthFromDisparity(disparity_px), depth_m, 1e-9 * depth_m);
    }
  }
}

TEST(RectifiedPair, DepthFollowsTheFormulaOfTheMessageType) {
  // z = f·b / (d + cx' − cx) = 200 / (90 + 600 − 640)
  EXPECT_DOUBLE_EQ(MakePair(640, 600).DepthFromDisparity(90), 4.0);
  EXPECT_DOUBLE_EQ(MakePair(640, 600).DisparityFromDepth(4), 90.0);
  EXPECT_DOUBLE_EQ(MakePair(640, 640).DepthFromDisparity(50), 4.0);
}

// f·b = 200: z = 4 m at 90 px, and 16 / 200 = 0.08 m a px.
TEST(DepthSigmaMap, IsTheSquareOfTheDepthTimesTheDisparitys) {
  EXPECT_DOUBLE_EQ(MakePair(640, 600).DepthSigma(90, 0.5), 0.04);
  const DisparityImage map(
      cv::Mat1s((cv::Mat1s(1, 4) << 90 * 32, 90 * 32, 40 * 32, DisparityImage::kInvalid)));
  const cv::Mat1b sigma = (cv::Mat1b(1, 4) << 8, 255, 8, 255);
  const cv::Mat1f sigma_m = DepthSigmaMap(MakePair(640, 600), map, sigma);
  EXPECT_FLOAT_EQ(sigma_m(0, 0), 0.04F);
  EXPECT_TRUE(std::isinf(sigma_m(0, 1))) << "15.94 px or more";
  EXPECT_TRUE(std::isnan(sigma_m(0, 2))) << "infinitely far";
  EXPECT_TRUE(std::isnan(sigma_m(0, 3))) << "no disparity";
}

TEST(RectifiedPair, APointAtInfinityHasTheDisparityOfThePrincipalPoints) {
  EXPECT_DOUBLE_EQ(MakePair(640, 600).DisparityFromDepth(std::numeric_limits<double>::infinity()),
                   40.0);
}

}  // namespace
}  // namespace sprout
