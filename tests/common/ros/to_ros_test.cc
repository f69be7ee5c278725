#include <gmock/gmock.h>

#include <cmath>
#include <string>

#include "common/ros/frame_topics.h"
#include "common/ros/from_ros.h"
#include "tests/common/ros/ros_examples.h"

namespace sprout {
namespace {

using examples::ErrorOf;
using examples::Place;

TEST(ToRos, PointsHavePlaceColourAndConfidence) {
  const PointCloud cloud{{{.position_m = {1, 2, 3}, .bgr = {10, 20, 30}, .confidence = 200}}};
  const auto ros = ToRosCloud(Place(), cloud);
  EXPECT_EQ(ros->point_step, 20U);
  const uint8_t* const at = ros->data._buffer;
  EXPECT_EQ(at[12], 10);
  EXPECT_EQ(at[13], 20);
  EXPECT_EQ(at[14], 30);
  EXPECT_EQ(at[16], 200);
  const auto points = FromRosCloud(*ros);
  ASSERT_TRUE(points) << ErrorOf(points);
  EXPECT_THAT(*points, testing::ElementsAre(Eigen::Vector3d(1, 2, 3)));
}

// z = f·t / d, as image_geometry computes it, is the depth that the pair says.
TEST(ToRos, DisparitiesAreAdjustedByThePrincipalPoints) {
  const RectifiedPair pair = examples::Rig().pair;
  const DisparityImage disparity = examples::SmallDisparity();
  const auto ros = ToRosDisparity(Place(), disparity, pair);
  const cv::Mat1f px(3, 5, reinterpret_cast<float*>(ros->image.data._buffer));
  EXPECT_EQ(px(1, 2), disparity.Px(2, 1) + 310.75F - 320.5F);
  EXPECT_NEAR(ros->f * ros->t / px(1, 3), pair.DepthFromDisparity(disparity.Px(3, 1)), 1e-4);
  EXPECT_EQ(ros->min_disparity, px(1, 0));
  EXPECT_EQ(ros->max_disparity, px(1, 3));
  EXPECT_EQ(px(0, 0), ros->min_disparity - 1);
}

TEST(ToRos, DepthIsMillimetresOrMetres) {
  DepthImage depth{.counts = (cv::Mat1w(1, 3) << 0, 1500, 3), .metres_per_count = 0.001};
  const auto borrowed = ToRosDepth(Place(), depth, RosDepth::kMillimetres);
  EXPECT_EQ(RosText(borrowed->encoding), "16UC1");
  EXPECT_EQ(static_cast<const void*>(borrowed->data._buffer), depth.counts.data);
  const auto metres = ToRosDepth(Place(), depth, RosDepth::kMetres);
  const cv::Mat1f m(1, 3, reinterpret_cast<float*>(metres->data._buffer));
  EXPECT_TRUE(std::isnan(m(0, 0)));
  EXPECT_FLOAT_EQ(m(0, 1), 1.5F);
  depth.metres_per_count = 0.0005;
  const auto scaled = ToRosDepth(Place(), depth, RosDepth::kMillimetres);
  EXPECT_EQ(reinterpret_cast<const uint16_t*>(scaled->data._buffer)[1], 750);
}

TEST(ToRos, WhatMillimetresCannotSayIsNoDepth) {
  const DepthImage depth{.counts = (cv::Mat1w(1, 4) << 0, 6553, 6554, 65535),
                         .metres_per_count = 0.01};
  const cv::Mat1w expected = (cv::Mat1w(1, 4) << 0, 65530, 0, 0);
  EXPECT_EQ(cv::norm(RosMillimetres(depth), expected, cv::NORM_INF), 0);
}

TEST(ToRos, StandardDeviationsOfDepthsAreMetres) {
  const DepthImage sigma{.counts = (cv::Mat1w(1, 4) << 0, 1, 800, 65535),
                         .metres_per_count = 0.001 / 16};
  const auto ros = ToRos(RosTopic::kDepthSigma, examples::Id(), sigma, nullptr,
                         {.frames = {}, .depth = RosDepth::kMillimetres});
  ASSERT_NE(ros, nullptr);
  const auto image = ToRosDepthSigma(Place(), sigma);
  EXPECT_EQ(RosText(image->encoding), "32FC1");
  const cv::Mat1f m(1, 4, reinterpret_cast<float*>(image->data._buffer));
  EXPECT_TRUE(std::isnan(m(0, 0)));
  EXPECT_FLOAT_EQ(m(0, 1), 0.0000625F);
  EXPECT_FLOAT_EQ(m(0, 2), 0.05F);
  EXPECT_TRUE(std::isinf(m(0, 3)));
}

TEST(ToRos, StampsAreTheCaptures) {
  EXPECT_EQ(*FromRosStamp(ToRosImage(Place(), examples::GreyImage())->header), Place().utime);
  const RosTime before = RosStamp(-1);
  EXPECT_EQ(before.sec, -1);
  EXPECT_EQ(before.nanosec, 999'999'000U);
  RosHeader header{};
  header.stamp.nanosec = 1'000'000'000;
  EXPECT_THAT(ErrorOf(FromRosStamp(header)), testing::HasSubstr("nanosec = 1000000000"));
}

TEST(RosTopics, SayNothingOfAFrameWithoutCalibrationWhereTheyNeedIt) {
  const PartValue left = examples::GreyImage();
  EXPECT_NE(ToRos(RosTopic::kLeft, examples::Id(), left, nullptr, {}), nullptr);
  EXPECT_EQ(ToRos(RosTopic::kLeftInfo, examples::Id(), left, nullptr, {}), nullptr);
  EXPECT_EQ(RosTopicName(RowOf(RosTopic::kDepth), "/robot"), "/robot/depth/image_rect");
  EXPECT_EQ(RosTopicName(RowOf(RosTopic::kTransforms), "/robot"), "/tf_static");
}

TEST(ToRosDiagnostics, SayWhoIsSilentAndWhoHasStopped) {
  StageStatus running;
  running.state = StageStatus::State::kRunning;
  StageStatus warns = running;
  warns.last_error = "one camera is gone";
  StageStatus stopped;
  stopped.state = StageStatus::State::kStopped;
  const auto message = ToRosDiagnostics(
      1, {{"a", {running}}, {"b", {warns}}, {"c", {warns, 7}}, {"d", {stopped, 7}}});
  const auto all = RosSpan(message->status);
  ASSERT_EQ(all.size(), 4U);
  const std::pair<int, std::string> expected[] = {
      {0, "running"}, {1, "one camera is gone"}, {3, "silent for 7 s"}, {2, "stopped"}};
  for (size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].level, expected[i].first) << i;
    EXPECT_EQ(RosText(all[i].message), expected[i].second) << i;
  }
}

TEST(RosTopics, HaveTheFusedMapBesideTheSingleOne) {
  const Rig rig = examples::Rig();
  const PartValue map = examples::SmallDisparity();
  const auto single = ToRos(RosTopic::kDisparity, examples::Id(), map, &rig, {});
  const auto fused = ToRos(RosTopic::kFused, examples::Id(), map, &rig, {});
  std::vector<uint8_t> fused_bytes, single_bytes;
  WriteCdr(*fused, fused_bytes);
  WriteCdr(*single, single_bytes);
  EXPECT_EQ(fused_bytes, single_bytes);
  EXPECT_EQ(RowOf(RosTopic::kFused).part, Part::kFused);
  EXPECT_EQ(RosTopicName(RowOf(RosTopic::kFused), "/sprout"), "/sprout/fused/disparity");
  const PartValue grey = examples::GreyImage();
  EXPECT_NE(ToRos(RosTopic::kFusedConfidence, examples::Id(), grey, nullptr, {}), nullptr);
  EXPECT_EQ(RowOf(RosTopic::kFusedConfidence).part, Part::kFusedConfidence);
}

TEST(RosSchemas, HaveEveryTypeThatIsUsedOnce) {
  const std::string schema = RosSchema(RosTypeOf<RosDisparity>());
  for (const char* name : {"MSG: std_msgs/Header\n", "MSG: builtin_interfaces/Time\n",
                           "MSG: sensor_msgs/Image\n", "MSG: sensor_msgs/RegionOfInterest\n"}) {
    const size_t at = schema.find(name);
    EXPECT_NE(at, std::string::npos) << name;
    EXPECT_EQ(schema.find(name, at + 1), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace sprout
