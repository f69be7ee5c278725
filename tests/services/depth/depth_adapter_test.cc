#include "services/depth/depth_adapter.h"

#include <gmock/gmock.h>

#include <array>
#include <fstream>
#include <string>

#include "common/rig/rig_file.h"
#include "tests/common/config/with.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

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

// Two pixels at 160 and 320 m, one at infinity, one without a disparity; the others at 1 m.
Frame FarFrame() {
  Frame frame = FrameOf(7);
  cv::Mat1s counts = frame.disparity->counts().clone();
  std::copy_n(std::array<int16_t, 4>{2, 1, 0, DisparityImage::kInvalid}.begin(), 4, counts[0]);
  frame.disparity = DisparityImage(counts);
  return frame;
}

std::string ErrorOf(const DepthConfig& config) {
  return Thrown<ConfigError>([&] { DepthAdapter adapter(config); });
}

DepthAdapter Adapter(const std::string& config) { return DepthAdapter(With<DepthConfig>(config)); }

TEST(DepthAdapter, AnswersWithDepthAndCloud) {
  DepthAdapter adapter = Adapter("scale: 2 cloud_stride: 2");
  Frame frame = FrameOf(7);
  EXPECT_EQ(AddAnswer(adapter, frame), "");
  ASSERT_TRUE(frame.depth && frame.cloud);
  EXPECT_EQ(frame.depth->size(), cv::Size(4, 3));
  EXPECT_EQ(frame.depth->Metres(0, 0), 1);
  EXPECT_EQ(frame.cloud->points.size(), 12U);
  EXPECT_EQ(frame.cloud->points[0].confidence, 100);
}

TEST(DepthAdapter, SaysThatACloudIsCutOff) {
  DepthAdapter adapter = Adapter("publish_depth: false cloud_stride: 1");
  Frame frame = FrameOf(7, {4000, 3001});
  EXPECT_THAT(AddAnswer(adapter, frame), HasSubstr("the cloud ends at 12000000 points"));
  EXPECT_EQ(frame.cloud->points.size(), 12'000'000U);
}

TEST(DepthAdapter, SaysHowManyDepthsAreTooFarForItsMessage) {
  Frame frame = FarFrame();
  EXPECT_EQ(
      Adapter("").Process(frame).finding,
      "SPROUT_DEPTH leaves out 2 of 47 pixels, which are farther than 65.5 m; a larger depth { "
      "mm_per_count } has them");
  EXPECT_EQ(Adapter("mm_per_count: 5").Process(frame).finding, "");
}

TEST(DepthAdapter, JoinsWhatItNeeds) {
  EXPECT_EQ(Adapter("").Inputs(),
            (PartSet{Part::kDisparity, Part::kRig, Part::kLeft, Part::kConfidence}));
  EXPECT_EQ(Adapter("confidence: false").Inputs(),
            (PartSet{Part::kDisparity, Part::kRig, Part::kLeft}));
}

TEST(DepthAdapter, TakesTheFusedMapWhenToldTo) {
  DepthAdapter adapter = Adapter("input: FUSED");
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
  auto config = With<DepthConfig>("publish_cloud: false publish_sigma: true");
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
  DepthAdapter adapter = Adapter("publish_cloud: false every: 3");
  EXPECT_THAT(adapter.Process(FrameOf(4)).outputs, IsEmpty());
  const StageResult outcome = adapter.Process(FrameOf(6));
  ASSERT_EQ(outcome.outputs.size(), 1U);
  EXPECT_EQ(outcome.outputs[0].part, Part::kDepth);
}

TEST(DepthAdapter, MakesAPreviewWhenAskedTo) {
  EXPECT_TRUE(Adapter("").Process(FrameOf(0)).preview.empty());
  DepthAdapter adapter = Adapter("publish_depth: false publish_cloud: false publish_preview: true");
  EXPECT_EQ(adapter.Inputs(), (PartSet{Part::kDisparity, Part::kRig, Part::kLeft}));
  const StageResult outcome = adapter.Process(FrameOf(0));
  EXPECT_THAT(outcome.outputs, IsEmpty());
  EXPECT_EQ(outcome.preview.type(), CV_8UC3);
}

TEST(DepthAdapter, CountsWhatItLeavesOutOfEverything) {
  DepthAdapter off = Adapter("cloud_stride: 1");
  Frame frame = FrameOf(0);
  EXPECT_EQ(AddAnswer(off, frame), "");
  EXPECT_FALSE(frame.depth_counts);
  DepthAdapter adapter = Adapter("cloud_stride: 1 min_confidence: 101 region: [0, 0, 7, 5]");
  frame.confidence(cv::Rect(2, 1, 3, 1)) = 101;
  EXPECT_EQ(AddAnswer(adapter, frame), "");
  EXPECT_EQ(*frame.depth_counts, (DepthCounts{.pixels = 48, .unsure = 45}));
  EXPECT_EQ(cv::countNonZero(frame.depth->counts), 3);
  EXPECT_EQ(frame.depth->counts(1, 2), 1000);
  EXPECT_EQ(frame.cloud->points.size(), 3U);
}

// As of a grow of one's own that gives shares, not 255 times a probability.
TEST(DepthAdapter, SaysThatNoConfidenceIsEnough) {
  DepthAdapter adapter = Adapter("min_confidence: 2 max_m: 1");
  Frame frame = FrameOf(0);
  frame.confidence = 1;
  EXPECT_THAT(AddAnswer(adapter, frame),
              HasSubstr("of depth.min_confidence, 2; the largest is 1 of 255"));
  frame = FrameOf(1);
  frame.confidence = 1;
  DepthAdapter nearer = Adapter("min_confidence: 2 max_m: 0.5");
  EXPECT_EQ(AddAnswer(nearer, frame), "") << "nothing near";
}

TEST(DepthAdapter, SaysThatItsRegionLiesOutside) {
  DepthAdapter adapter = Adapter("region: [8, 0, 20, 5]");
  for (int i = 0; i < 2; ++i) {
    Frame frame = FrameOf(i);
    EXPECT_THAT(AddAnswer(adapter, frame), HasSubstr("depth.region lies outside the image of 8x6"));
    EXPECT_EQ(*frame.depth_counts, (DepthCounts{.pixels = 48, .outside = 48}));
  }
}

TEST(DepthAdapter, JoinsTheConfidenceForItsRuleToo) {
  const auto joins = [](const char* config) {
    return Adapter(config).Inputs().Has(Part::kConfidence);
  };
  EXPECT_FALSE(joins("publish_cloud: false"));
  EXPECT_TRUE(joins("publish_cloud: false min_confidence: 1"));
}

class DepthAdapterWithRig : public ::testing::Test {
 protected:
  DepthAdapterWithRig() {
    Write("");
    config_.set_rig(path_);
    config_.set_cloud_stride(1);
  }

  // A camera 1 cm to the right of the left one; the robot's frame is 2 m below it, forward is z.
  void Write(const std::string& more) {
    std::ofstream(path_) << R"(
      others {
        name: "thermal"
        lens { width: 8 height: 6 fx: 100 fy: 100 cx: 4 cy: 3 }
        pose { rotation: [1, 0, 0, 0] translation_m: [0.01, 0, 0] }
      }
      base_from_left { rotation: [0.5, -0.5, 0.5, -0.5] translation_m: [0, 0, 2] }
    )" << more;
  }

  TemporaryDirectory folder_;
  std::string path_ = folder_ / "rig.textproto";
  DepthConfig config_;
};

TEST_F(DepthAdapterWithRig, GivesDepthAndPointsAsTheTargetSeesThem) {
  config_.set_target("thermal");
  DepthAdapter adapter(config_);
  Frame frame = FrameOf(0);
  EXPECT_EQ(AddAnswer(adapter, frame), "");
  ASSERT_TRUE(frame.target_depth && frame.target_cloud);
  // At 1 m it is 1 px to the left: the last column is not seen.
  EXPECT_EQ(cv::countNonZero(frame.target_depth->counts == 1000), 42);
  EXPECT_EQ(cv::countNonZero(frame.target_depth->counts.col(7)), 0);
  EXPECT_EQ(frame.target_cloud->points.size(), 42U);
  EXPECT_EQ(frame.target_cloud->points[0].position_m, cv::Point3f(-0.04F, -0.03F, 1));
  EXPECT_EQ(frame.target_cloud->points[0].confidence, 100);
}

TEST_F(DepthAdapterWithRig, GivesPointsInTheRobotsFrame) {
  DepthAdapter adapter(config_);
  Frame frame = FrameOf(0);
  EXPECT_EQ(AddAnswer(adapter, frame), "");
  ASSERT_TRUE(frame.base_cloud);
  ASSERT_EQ(frame.base_cloud->points.size(), 48U);
  EXPECT_EQ(frame.cloud->points[0].position_m, cv::Point3f(-0.04F, -0.03F, 1));
  EXPECT_EQ(frame.base_cloud->points[0].position_m, cv::Point3f(1, 0.04F, 2.03F));
}

TEST_F(DepthAdapterWithRig, LimitsToABoxInTheRobotsFrame) {
  config_.mutable_box()->set_min_z_m(2.005);
  DepthAdapter adapter(config_);
  Frame frame = FrameOf(0);
  EXPECT_EQ(AddAnswer(adapter, frame), "");
  EXPECT_EQ(*frame.depth_counts, (DepthCounts{.pixels = 48, .outside = 24})) << "rows 3 to 5";
  config_.clear_rig();
  EXPECT_THAT(ErrorOf(config_), HasSubstr("depth.box: needs depth.rig"));
}

TEST_F(DepthAdapterWithRig, ScansBetweenHeightsOfTheRobot) {
  EXPECT_FALSE(Adapter("").Process(FrameOf(0)).scan);
  const auto between =
      With("publish_scan: true scan_min_height_m: 1.9 scan_max_height_m: 2.1", config_);
  const auto scan = DepthAdapter(between).Process(FrameOf(0)).scan;
  ASSERT_TRUE(scan);
  // Columns 0 and 7 are at 2.29 and −1.72 degrees; steps are of 0.25.
  EXPECT_EQ(scan->first, -7);
  EXPECT_EQ(scan->ranges_m.size(), 17U);
  EXPECT_FLOAT_EQ(scan->ranges_m[7], 1);
}

TEST_F(DepthAdapterWithRig, NeedsTheCalibrationOfTheRigFile) {
  Write(R"(calibration {
    left { width: 8 height: 6 fx: 100 fy: 100 cx: 4 cy: 3 }
    right { width: 8 height: 6 fx: 100 fy: 100 cx: 4 cy: 3 }
    left_from_right { rotation: [1, 0, 0, 0] translation_m: [0.2, 0, 0] }
  })");
  config_.set_target("thermal");
  DepthAdapter adapter(config_);
  Frame frame = FrameOf(0);  // with a baseline of 0.1 m
  EXPECT_THAT(AddAnswer(adapter, frame), HasSubstr("RIG is not the calibration in depth.rig"));
  EXPECT_TRUE(frame.depth && frame.cloud);
  EXPECT_FALSE(frame.base_cloud || frame.target_depth || frame.target_cloud);
  frame.rig->pair = *PlacesOf(LoadRigFile(path_), path_).pair;
  EXPECT_EQ(AddAnswer(adapter, frame), "");
  EXPECT_TRUE(frame.base_cloud && frame.target_depth && frame.target_cloud);
}

TEST_F(DepthAdapterWithRig, NamesTheCamerasThatItKnows) {
  config_.set_target("rgb");
  EXPECT_THAT(ErrorOf(config_), HasSubstr("depth.target = 'rgb': allowed: thermal"));
  config_.clear_rig();
  EXPECT_THAT(ErrorOf(config_), HasSubstr("needs depth.rig"));
}

TEST(DepthAdapter, SaysWhichSizesDoNotFitTogether) {
  DepthAdapter adapter{DepthConfig()};
  Frame frame = FrameOf(0);
  frame.left = cv::Mat(5, 8, CV_8UC1, cv::Scalar(0));
  EXPECT_THAT(adapter.Process(frame).degenerate, HasSubstr("LEFT of 8x5"));
  frame = FrameOf(0);
  frame.confidence = cv::Mat(5, 8, CV_8UC1, cv::Scalar(0));
  EXPECT_THAT(adapter.Process(frame).degenerate, HasSubstr("CONFIDENCE of 8x5"));
  frame.confidence = cv::Mat(6, 8, CV_8UC3, cv::Scalar());
  EXPECT_THAT(adapter.Process(frame).degenerate,
              HasSubstr("CONFIDENCE of 8x6 and 3 bytes a pixel"));
  frame = FrameOf(0);
  frame.rig->pair.width = 9;
  EXPECT_THAT(adapter.Process(frame).degenerate, HasSubstr("DISPARITY of 8x6"));
  EXPECT_THAT(adapter.Process(frame).outputs, IsEmpty());
}

TEST(DepthAdapter, RefusesValuesThatItCannotUse) {
  const std::pair<const char*, const char*> table[] = {
      {"scale: 3", "depth.scale = 3: allowed: 1, 2, 4"},
      {"mm_per_count: 0", "depth.mm_per_count = 0"},
      {"publish_cloud: false publish_depth: false", "nothing to publish"},
      {"publish_cloud: false publish_depth: false publish_sigma: true", "no error"},
      {"publish_sigma: true input: FUSED", "depth.publish_sigma = true: fused maps have no"},
      {"min_m: 3", "no error"},
      {"min_m: 3 max_m: 2", "depth.max_m = 2"},
      {"min_confidence: 5 confidence: false", "needs depth.confidence: true"},
      {"region: 40000", "depth.region: 40000; allowed"},
      {"region: 4", "depth.region: 1 numbers"},
      {"region: [4, 4]", "depth.region: 2 numbers"},
      {"publish_scan: true scan_max_height_m: 0.1", "depth.scan_max_height_m = 0.1"}};
  for (const auto& [config, error] : table) {
    EXPECT_THAT(ErrorOf(With<DepthConfig>(config)), HasSubstr(error)) << config;
  }
  DepthConfig corners;
  for (int i = 0; i < 2 * 1001; ++i) corners.add_region(i);
  EXPECT_THAT(ErrorOf(corners), HasSubstr("depth.region: 1001 corners; allowed: up to 1000"));
}

}  // namespace
}  // namespace sprout::depth
