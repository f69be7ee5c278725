#include "services/depth/depth_adapter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sprout::depth {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

Frame FrameOf(int64_t seq, cv::Size size = {8, 6}) {
  Frame frame;
  frame.id.seq = seq;
  frame.disparity = DisparityImage(cv::Mat1s(size, int16_t{320}));
  frame.left = cv::Mat(size, CV_8UC1, cv::Scalar(9));
  frame.confidence = cv::Mat(size, CV_8UC1, cv::Scalar(100));
  frame.rig = Rig{.pair = {.width = size.width,
                           .height = size.height,
                           .focal_px = 100,
                           .cx = 4,
                           .cy = 3,
                           .cx_right = 4,
                           .baseline_m = 0.1},
                  .tof = {}};
  return frame;
}

std::string ErrorOf(const DepthConfig& config) {
  try {
    DepthAdapter adapter(config);
    return "no error";
  } catch (const ConfigError& e) {
    return e.what();
  }
}

TEST(DepthAdapter, AnswersWithDepthAndCloud) {
  DepthConfig config;
  config.set_scale(2);
  config.set_cloud_stride(2);
  DepthAdapter adapter(config);
  Frame frame = FrameOf(7);
  EXPECT_EQ(AddAnswer(adapter, frame), "");
  ASSERT_TRUE(frame.depth && frame.cloud);
  EXPECT_EQ(frame.depth->size(), cv::Size(4, 3));
  EXPECT_EQ(frame.depth->Metres(0, 0), 1);
  EXPECT_EQ(frame.cloud->points.size(), 12U);
  EXPECT_EQ(frame.cloud->points[0].confidence, 100);
}

TEST(DepthAdapter, JoinsWhatItNeeds) {
  DepthConfig config;
  EXPECT_EQ(DepthAdapter(config).Inputs(),
            (PartSet{Part::kDisparity, Part::kRig, Part::kLeft, Part::kConfidence}));
  config.set_confidence(false);
  EXPECT_EQ(DepthAdapter(config).Inputs(), (PartSet{Part::kDisparity, Part::kRig, Part::kLeft}));
}

TEST(DepthAdapter, TakesTheFusedMapWhenToldTo) {
  DepthConfig config;
  config.set_input(DepthConfig::FUSED);
  DepthAdapter adapter(config);
  EXPECT_EQ(adapter.Inputs(),
            (PartSet{Part::kFused, Part::kRig, Part::kLeft, Part::kFusedConfidence}));
  Frame frame = FrameOf(7);
  frame.fused = DisparityImage(cv::Mat1s(frame.left.size(), int16_t{640}));
  frame.fused_confidence = cv::Mat(frame.left.size(), CV_8UC1, cv::Scalar(50));
  frame.disparity.reset();
  EXPECT_EQ(AddAnswer(adapter, frame), "");
  EXPECT_EQ(frame.depth->Metres(0, 0), 0.5);
  EXPECT_EQ(frame.cloud->points[0].confidence, 50);
}

// z = 100 · 0.1 / 10 = 1 m, z² / (f·b) = 0.1 m a px; σ = 0.5 px.
TEST(DepthAdapter, AnswersWithTheStandardDeviationOfTheDepthWhenAskedTo) {
  DepthConfig config;
  config.set_publish_cloud(false);
  config.set_publish_sigma(true);
  EXPECT_EQ(DepthAdapter(config).Inputs(),
            (PartSet{Part::kDisparity, Part::kRig, Part::kLeft, Part::kSigma}));
  for (const bool with_depth : {true, false}) {
    config.set_publish_depth(with_depth);
    DepthAdapter adapter(config);
    Frame frame = FrameOf(7);
    frame.sigma = cv::Mat(frame.left.size(), CV_8UC1, cv::Scalar(8));
    EXPECT_EQ(AddAnswer(adapter, frame), "");
    EXPECT_EQ(frame.depth.has_value(), with_depth);
    ASSERT_TRUE(frame.depth_sigma);
    EXPECT_EQ(frame.depth_sigma->size(), frame.left.size());
    EXPECT_DOUBLE_EQ(frame.depth_sigma->Metres(2, 3), 0.05);
  }
  Frame frame = FrameOf(7);
  frame.sigma = cv::Mat(5, 8, CV_8UC1, cv::Scalar(8));
  EXPECT_THAT(DepthAdapter(config).Process(frame).degenerate, HasSubstr("SIGMA of 8x5"));
  frame.sigma = cv::Mat(6, 8, CV_8UC3, cv::Scalar::all(8));
  EXPECT_THAT(DepthAdapter(config).Process(frame).degenerate, HasSubstr("3 bytes a pixel"));
}

TEST(DepthAdapter, LeavesOutWhatIsNotAskedFor) {
  DepthConfig config;
  config.set_publish_cloud(false);
  config.set_every(3);
  DepthAdapter adapter(config);
  EXPECT_THAT(adapter.Process(FrameOf(4)).outputs, IsEmpty());
  const StageResult outcome = adapter.Process(FrameOf(6));
  ASSERT_EQ(outcome.outputs.size(), 1U);
  EXPECT_EQ(outcome.outputs[0].part, Part::kDepth);
}

TEST(DepthAdapter, MakesAPreviewWhenAskedTo) {
  DepthConfig config;
  EXPECT_TRUE(DepthAdapter(config).Process(FrameOf(0)).preview.empty());
  config.set_publish_depth(false);
  config.set_publish_cloud(false);
  config.set_publish_preview(true);
  DepthAdapter adapter(config);
  EXPECT_EQ(adapter.Inputs(), (PartSet{Part::kDisparity, Part::kRig, Part::kLeft}));
  const StageResult outcome = adapter.Process(FrameOf(0));
  EXPECT_THAT(outcome.outputs, IsEmpty());
  EXPECT_EQ(outcome.preview.type(), CV_8UC3);
}

TEST(DepthAdapter, SaysWhichSizesDoNotFitTogether) {
  DepthAdapter adapter{DepthConfig()};
  Frame frame = FrameOf(0);
  frame.left = cv::Mat(5, 8, CV_8UC1, cv::Scalar(0));
  EXPECT_THAT(adapter.Process(frame).degenerate, HasSubstr("LEFT of 8x5"));
  frame = FrameOf(0);
  frame.confidence = cv::Mat(5, 8, CV_8UC1, cv::Scalar(0));
  EXPECT_THAT(adapter.Process(frame).degenerate, HasSubstr("CONFIDENCE of 8x5"));
  frame = FrameOf(0);
  frame.rig->pair.width = 9;
  EXPECT_THAT(adapter.Process(frame).degenerate, HasSubstr("DISPARITY of 8x6"));
  EXPECT_THAT(adapter.Process(frame).outputs, IsEmpty());
}

TEST(DepthAdapter, RefusesValuesThatItCannotUse) {
  DepthConfig config;
  config.set_scale(3);
  EXPECT_THAT(ErrorOf(config), HasSubstr("depth.scale = 3: allowed: 1, 2, 4"));
  config = {};
  config.set_mm_per_count(0);
  EXPECT_THAT(ErrorOf(config), HasSubstr("depth.mm_per_count = 0"));
  config = {};
  config.set_publish_cloud(false);
  config.set_publish_depth(false);
  EXPECT_THAT(ErrorOf(config), HasSubstr("nothing to publish"));
  config.set_publish_sigma(true);
  EXPECT_EQ(ErrorOf(config), "no error");
  config.set_input(DepthConfig::FUSED);
  EXPECT_THAT(ErrorOf(config), HasSubstr("depth.publish_sigma = true: fused maps have no"));
}

}  // namespace
}  // namespace sprout::depth
