#include "services/depth/depth_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/core/prior_map.h"
#include "services/depth/cloud.h"

namespace sprout::depth {
namespace {

// f·b = 50 m px; z = 50 / (d − 2 px).
RectifiedPair Pair(cv::Size size) {
  return {.width = size.width,
          .height = size.height,
          .focal_px = 500,
          .cx = 3.5,
          .cy = 2.5,
          .cx_right = 1.5,
          .baseline_m = 0.1};
}

TEST(DepthMap, HasTheDepthOfEveryDisparityInUnitsOfItsCount) {
  const RectifiedPair pair = Pair({4, 1});
  const DisparityImage disparity(
      cv::Mat1s((cv::Mat1s(1, 4) << 32 * 12, 32 * 27 + 8, 32 * 100, 32 * 3)));
  const DepthImage depth = DepthOf(disparity, pair, 0.001, 1);
  EXPECT_EQ(depth.counts(0, 0), 5000);  // 500 · 0.1 / (12 + 1.5 − 3.5)
  EXPECT_EQ(depth.counts(0, 1), std::lround(50 / 25.25 * 1000));
  EXPECT_EQ(depth.counts(0, 2), std::lround(50 / 98.0 * 1000));
  EXPECT_EQ(depth.counts(0, 3), 50000);
  EXPECT_EQ(depth.metres_per_count, 0.001);
  EXPECT_EQ(depth.focal_px, 500);
  EXPECT_EQ(depth.cx, 3.5);
  EXPECT_DOUBLE_EQ(DepthOf(disparity, pair, 0.0005, 1).Metres(0, 0), 5);
}

TEST(DepthMap, HasNoDepthWithoutADisparityAtInfinityAndBeyondItsRange) {
  const RectifiedPair pair = Pair({5, 1});
  const DisparityImage disparity(
      cv::Mat1s((cv::Mat1s(1, 5) << DisparityImage::kInvalid, 64, 60, -32767, 64 + 24)));
  const DepthImage depth = DepthOf(disparity, pair, 0.001, 1);
  for (int u = 0; u < 4; ++u) EXPECT_EQ(depth.counts(0, u), 0) << u;
  EXPECT_EQ(depth.counts(0, 4), 0) << "66.7 m";
  EXPECT_NEAR(DepthOf(disparity, pair, 0.01, 1).Metres(4, 0), 50 / 0.75, 0.005);
}

TEST(DepthMap, HasTheMedianOfEachBlockWhenItIsSmaller) {
  const RectifiedPair pair = Pair({5, 2});
  const int16_t none = DisparityImage::kInvalid;
  // Depths of 5, 2.5, 1 and 0.5 m.
  const int16_t far = 32 * 12, middle = 32 * 22, near = 32 * 52, nearest = 32 * 102;
  const DisparityImage disparity(cv::Mat1s((cv::Mat1s(2, 5) << far, near, none, near, none,  //
                                            middle, nearest, none, none, near)));
  const DepthImage depth = DepthOf(disparity, pair, 0.001, 2);
  ASSERT_EQ(depth.size(), cv::Size(2, 1));
  EXPECT_EQ(depth.counts(0, 0), 1000) << "the lower one in the middle";
  EXPECT_EQ(depth.counts(0, 1), 0) << "a quarter of the block only";
}

TEST(DepthMap, KeepsTheViewWhenItIsSmaller) {
  const RectifiedPair pair = Pair({8, 8});
  const DepthImage depth = DepthOf(DisparityImage(cv::Mat1s(8, 8, int16_t{320})), pair, 0.001, 4);
  ASSERT_EQ(depth.size(), cv::Size(2, 2));
  // The middle of the first block, column 1.5, is column 0 now.
  EXPECT_DOUBLE_EQ((0 - depth.cx) / depth.focal_px, (1.5 - pair.cx) / pair.focal_px);
  EXPECT_DOUBLE_EQ((1 - depth.cy) / depth.focal_px, (5.5 - pair.cy) / pair.focal_px);
}

DepthImage SigmaOf(const DisparityImage& disparity, const cv::Mat1b& sigma, int scale = 1,
                   double metres_per_count = 0.001) {
  const RectifiedPair pair = Pair(disparity.size());
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
  const RectifiedPair pair = Pair({1, 1});
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
  const RectifiedPair pair = Pair(size);
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

class CloudTest : public ::testing::Test {
 protected:
  CloudTest() {
    for (int v = 0; v < left_.rows; ++v) {
      for (int u = 0; u < left_.cols; ++u) {
        left_(v, u) = {static_cast<uint8_t>(u), static_cast<uint8_t>(v), 200};
        confidence_(v, u) = static_cast<uint8_t>(10 * v + u);
      }
    }
  }

  PointCloud Cloud(const CloudThinning& thinning = {}) const {
    return CloudOf(disparity_, pair_, left_, confidence_, thinning);
  }

  RectifiedPair pair_{
      .width = 8, .height = 6, .focal_px = 100, .cx = 4, .cy = 3, .cx_right = 4, .baseline_m = 0.1};
  DisparityImage disparity_{cv::Mat1s(6, 8, int16_t{32 * 5})};  // 2 m
  cv::Mat3b left_ = cv::Mat3b(6, 8);
  cv::Mat1b confidence_ = cv::Mat1b(6, 8);
};

TEST_F(CloudTest, HasThePointColourAndConfidenceOfEveryPixel) {
  const PointCloud cloud = Cloud();
  ASSERT_EQ(cloud.points.size(), 48U);
  const CloudPoint& point = cloud.points[8 * 2 + 7];
  EXPECT_EQ(point.position_m, cv::Point3f(0.06F, -0.02F, 2));
  EXPECT_EQ(point.bgr, cv::Vec3b(7, 2, 200));
  EXPECT_EQ(point.confidence, 27);
}

TEST_F(CloudTest, LeavesOutPixelsWithoutDepth) {
  disparity_.counts()(0, 0) = DisparityImage::kInvalid;
  disparity_.counts()(0, 1) = 0;  // infinity
  disparity_.counts()(0, 2) = -5;
  EXPECT_EQ(Cloud().points.size(), 45U);
}

TEST_F(CloudTest, TakesGreyImagesAndNoConfidence) {
  const cv::Mat1b grey(6, 8, uint8_t{77});
  const PointCloud cloud = CloudOf(disparity_, pair_, grey, {}, {});
  EXPECT_EQ(cloud.points[0].bgr, cv::Vec3b(77, 77, 77));
  EXPECT_EQ(cloud.points[0].confidence, 255);
}

TEST_F(CloudTest, IsThinnedByStrideAndByVoxels) {
  const PointCloud by_stride = Cloud({.stride = 3});
  ASSERT_EQ(by_stride.points.size(), 6U);
  EXPECT_EQ(by_stride.points[4].bgr, cv::Vec3b(3, 3, 200));
  // Pixels lie 2 cm apart; x from −8 to 6 cm, y from −6 to 4 cm.
  const PointCloud by_voxel = Cloud({.voxel_m = 0.05});
  ASSERT_EQ(by_voxel.points.size(), 12U);
  EXPECT_EQ(by_voxel.points[0], Cloud().points[0]) << "the first of its voxel";
}

}  // namespace

}  // namespace sprout::depth
