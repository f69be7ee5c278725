#include "services/depth/cloud.h"

#include <gtest/gtest.h>

#include "common/geometry/projection.h"

namespace sprout::depth {
namespace {

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
