#include "services/depth/depth_sigma.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/core/prior_map.h"
#include "services/depth/cloud.h"
#include "services/depth/depth_map.h"

namespace sprout::depth {
namespace {

// f·b = 50 m px; z = 50 / (d − 2 px).
RectifiedPair SigmaPair(cv::Size size) {
  return {.width = size.width,
          .height = size.height,
          .focal_px = 500,
          .cx = 3.5,
          .cy = 2.5,
          .cx_right = 1.5,
          .baseline_m = 0.1};
}

DepthImage SigmaOf(const DisparityImage& disparity, const cv::Mat1b& sigma, int scale = 1,
                   double metres_per_count = 0.001) {
  const RectifiedPair pair = SigmaPair(disparity.size());
  return DepthSigmaOf(DepthOf(disparity, pair, metres_per_count, scale), disparity, sigma, pair,
                      scale);
}

TEST(DepthSigma, IsTheSquareOfTheDepthTimesTheDisparitys) {
  // Depths of 5, 2, 0.5 and 50 m; 1, 0.25, 1/16 and 1/16 px.
  const DisparityImage disparity(
      cv::Mat1s((cv::Mat1s(1, 4) << 32 * 12, 32 * 27, 32 * 102, 32 * 3)));
  const cv::Mat1b sigma = (cv::Mat1b(1, 4) << 16, 4, 1, 1);
  const DepthImage image = SigmaOf(disparity, sigma);
  EXPECT_EQ(image.metres_per_count, 0.001 / 16);
  EXPECT_EQ(image.counts(0, 0), 16 * 500);  // 25 / 50 = 0.5 m
  EXPECT_EQ(image.counts(0, 1), 16 * 20);   // 4 / 50 / 4 = 20 mm
  EXPECT_EQ(image.counts(0, 2), 5);         // 0.25 / 50 / 16 = 0.3125 mm
  EXPECT_EQ(image.counts(0, 3), 16 * 3125);
  EXPECT_EQ(image.focal_px, 500);
  EXPECT_EQ(image.cx, 3.5);
  EXPECT_EQ(SigmaOf(disparity, sigma, 1, 0.01).counts(0, 0), 16 * 50);
}

TEST(DepthSigma, SaysWhatIsTooLargeTooSmallOrNotThere) {
  const DisparityImage disparity(
      cv::Mat1s((cv::Mat1s(1, 5) << 32 * 3, 32 * 12, 32 * 1002, DisparityImage::kInvalid, 64)));
  const cv::Mat1b sigma = (cv::Mat1b(1, 5) << 16, 255, 1, 255, 3);
  const DepthImage image = SigmaOf(disparity, sigma);
  EXPECT_EQ(image.counts(0, 0), kMaxDepthSigmaCounts) << "50 m";
  EXPECT_EQ(image.counts(0, 1), kMaxDepthSigmaCounts) << "not known";
  EXPECT_EQ(image.counts(0, 2), 1) << "3 µm";
  EXPECT_EQ(image.counts(0, 3), 0) << "no disparity";
  EXPECT_EQ(image.counts(0, 4), 0) << "infinitely far";
}

// The error of the depth for a disparity that is off by σ, to first order.
TEST(DepthSigma, IsHowFarTheDepthMovesWithTheDisparity) {
  std::mt19937 random(3);
  const RectifiedPair pair = SigmaPair({1, 1});
  for (int i = 0; i < 200; ++i) {
    const auto counts = static_cast<int16_t>(32 * 12 + random() % 3000);
    const auto sigma = static_cast<uint8_t>(1 + random() % 16);
    const double d = counts / 32.0;
    const double h = 1e-4;
    const double slope =
        (pair.DepthFromDisparity(d - h) - pair.DepthFromDisparity(d + h)) / (2 * h);
    const DepthImage image =
        SigmaOf(DisparityImage(cv::Mat1s(1, 1, counts)), cv::Mat1b(1, 1, sigma), 1, 0.0001);
    const double expected = slope * sigma / 16;
    if (expected < 60000 * image.metres_per_count) {
      EXPECT_NEAR(image.Metres(0, 0), expected, 0.51 * image.metres_per_count) << d;
    }
  }
}

TEST(DepthSigma, IsThatOfThePixelWhoseDepthABlockHas) {
  const int16_t none = DisparityImage::kInvalid;
  // Depths of 5, 2.5, 1 and 0.5 m.
  const int16_t far = 32 * 12, middle = 32 * 22, near = 32 * 52, nearest = 32 * 102;
  const DisparityImage disparity(
      cv::Mat1s((cv::Mat1s(2, 6) << far, near, near, near, none, none,  //
                 middle, nearest, near, none, none, near)));
  const cv::Mat1b sigma = (cv::Mat1b(2, 6) << 10, 32, 3, 7, 255, 255,  //
                           20, 40, 5, 255, 255, 8);
  const DepthImage image = SigmaOf(disparity, sigma, 2);
  ASSERT_EQ(image.size(), cv::Size(3, 1));
  EXPECT_EQ(image.counts(0, 0), 16 * 40) << "near: 1 / 50 · 2 px = 40 mm";
  EXPECT_EQ(image.counts(0, 1), 140) << "the least sure of three: 20 mm · 7 / 16";
  EXPECT_EQ(image.counts(0, 2), 0) << "a quarter of the block only";
  EXPECT_EQ(image.focal_px, 250);
}

TEST(DepthSigma, OfAPointOfTheCloudIsWhereItIsSeen) {
  const cv::Size size(40, 30);
  const RectifiedPair pair = SigmaPair(size);
  std::mt19937 random(5);
  DisparityImage disparity(size);
  cv::Mat1b sigma(size);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      disparity.counts()(v, u) = static_cast<int16_t>(32 * 12 + random() % 2000);
      sigma(v, u) = static_cast<uint8_t>(1 + random() % 40);
    }
  }
  const DepthImage image = SigmaOf(disparity, sigma);
  const PointCloud cloud =
      CloudOf(disparity, pair, cv::Mat1b(size, uint8_t{0}), sigma, {.stride = 3, .voxel_m = 0.03});
  ASSERT_GT(cloud.points.size(), 50U);
  for (const CloudPoint& point : cloud.points) {
    const cv::Point3f& p = point.position_m;
    const long u = std::lround(double{p.x} * image.focal_px / double{p.z} + image.cx);
    const long v = std::lround(double{p.y} * image.focal_px / double{p.z} + image.cy);
    // The cloud was told σ in place of the confidence.
    const double expected = double{p.z} * double{p.z} / 50 * point.confidence / 16;
    EXPECT_NEAR(image.Metres(static_cast<int>(u), static_cast<int>(v)), expected,
                image.metres_per_count)
        << p;
  }
}

}  // namespace
}  // namespace sprout::depth
