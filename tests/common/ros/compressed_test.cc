#include "common/ros/compressed.h"

#include <gmock/gmock.h>

#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "common/ros/from_ros.h"
#include "tests/common/ros/ros_examples.h"

namespace sprout {
namespace {

using examples::Place;

TEST(Compressed, PicturesAreJpeg) {
  const cv::Mat3b colours(48, 64, cv::Vec3b(10, 90, 200));
  const auto ros = ToRosJpeg(Place(), colours);
  EXPECT_EQ(RosText(ros->format), "bgr8; jpeg compressed bgr8");
  const Result<cv::Mat> back = FromRosImage(*ros, colours.size());
  ASSERT_TRUE(back);
  EXPECT_LE(cv::norm(*back, colours, cv::NORM_INF), 3);
  EXPECT_EQ(RosText(ToRosJpeg(Place(), cv::Mat1b(8, 8, uint8_t{1}))->format),
            "mono8; jpeg compressed ");
}

TEST(Compressed, DepthIsPngOfMillimetresBehindItsHeader) {
  const DepthImage depth{.counts = (cv::Mat1w(2, 3) << 0, 1, 2, 30'000, 65'535, 7),
                         .metres_per_count = 0.0005,
                         .focal_px = 1};
  const auto ros = ToRosCompressedDepth(Place(), depth);
  EXPECT_EQ(RosText(ros->format), "16UC1; compressedDepth png");
  const std::span bytes = RosSpan(ros->data);
  int32_t format = 0;
  std::memcpy(&format, bytes.data(), sizeof format);
  EXPECT_EQ(format, 1);
  const std::vector<uint8_t> png(bytes.begin() + 12, bytes.end());
  const cv::Mat back = cv::imdecode(png, cv::IMREAD_UNCHANGED);
  ASSERT_EQ(back.type(), CV_16UC1);
  EXPECT_EQ(cv::norm(back, RosMillimetres(depth), cv::NORM_INF), 0);
}

float FloatAt(const RosPointCloud& cloud, size_t index, size_t offset) {
  float value = 0;
  std::memcpy(&value, &RosSpan(cloud.data)[index * cloud.point_step + offset], sizeof value);
  return value;
}

TEST(OrderedCloud, APointIsAtItsPixel) {
  const RectifiedPair pair = examples::Rig().pair;
  const auto at = [&](double u, double v, double z) {
    return CloudPoint{.position_m = {static_cast<float>((u - pair.cx) * z / pair.focal_px),
                                     static_cast<float>((v - pair.cy) * z / pair.focal_px),
                                     static_cast<float>(z)},
                      .bgr = {1, 2, 3},
                      .confidence = 9};
  };
  const PointCloud cloud{{at(8, 4, 2), at(636, 476, 40)}};
  const auto ros = ToRosOrderedCloud(Place(), cloud, pair, 4);
  ASSERT_TRUE(ros);
  EXPECT_EQ((*ros)->width, 160U);
  EXPECT_EQ((*ros)->height, 120U);
  EXPECT_EQ((*ros)->row_step, 160 * (*ros)->point_step);
  EXPECT_FALSE((*ros)->is_dense);
  size_t points = 0;
  for (size_t i = 0; i < 160 * 120; ++i) points += std::isnan(FloatAt(**ros, i, 0)) ? 0 : 1;
  EXPECT_EQ(points, 2U);
  EXPECT_EQ(FloatAt(**ros, 1 * 160 + 2, 8), 2);
  EXPECT_EQ(FloatAt(**ros, 119 * 160 + 159, 8), 40);
  EXPECT_EQ(FromRosCloud(**ros)->size(), 2U);
  // Of another stride, or outside.
  EXPECT_FALSE(ToRosOrderedCloud(Place(), PointCloud{{at(9, 4, 2)}}, pair, 4));
  EXPECT_FALSE(ToRosOrderedCloud(Place(), PointCloud{{at(-4, 4, 2)}}, pair, 4));
}

}  // namespace
}  // namespace sprout
