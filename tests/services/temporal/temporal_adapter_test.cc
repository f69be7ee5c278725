#include "services/temporal/temporal_adapter.h"

#include <gmock/gmock.h>

#include "services/temporal/confidence_scale.h"
#include "tests/services/temporal/moving_scene.h"

namespace sprout::temporal {
namespace {

using ::testing::HasSubstr;

Frame FrameAt(int64_t seq) {
  const TemporalInput input = FrameFrom(SceneFrom(MovedBy(0.01 * double(seq), 0, 0)), seq, 0.2);
  Frame frame;
  frame.id = input.id;
  frame.left = input.left.clone();
  frame.disparity = input.disparity;
  frame.confidence = input.confidence;
  frame.rig = Rig{.pair = input.pair, .tof = {}};
  return frame;
}

TEST(TemporalAdapter, AddsMapConfidenceAndMotion) {
  TemporalAdapter adapter(LoadConfig({}).temporal());
  EXPECT_EQ(adapter.Inputs(),
            (PartSet{Part::kLeft, Part::kRig, Part::kDisparity, Part::kConfidence}));
  for (int64_t seq = 0; seq < 3; ++seq) {
    Frame frame = FrameAt(seq);
    EXPECT_EQ(AddAnswer(adapter, frame), "");
    ASSERT_TRUE(frame.fused && frame.motion);
    EXPECT_EQ(frame.fused_confidence.size(), frame.left.size());
    EXPECT_EQ(frame.motion->reset, seq == 0 ? MemoryReset::kFirst : MemoryReset::kNone);
    frame.left.setTo(0);  // whose memory is used again
  }
}

TEST(TemporalAdapter, SaysWhyItForgets) {
  TemporalAdapter adapter(LoadConfig({}).temporal());
  Frame frame = FrameAt(0);
  EXPECT_EQ(AddAnswer(adapter, frame), "");
  frame = FrameAt(1);
  frame.left.setTo(9);
  EXPECT_THAT(AddAnswer(adapter, frame), HasSubstr("only 0 points could be tracked"));
  frame.disparity = DisparityImage(cv::Size(5, 4));
  EXPECT_THAT(AddAnswer(adapter, frame), HasSubstr("DISPARITY of 5x4"));
  EXPECT_EQ(frame.motion->resets, 1) << "it is counted once";
}

TEST(TemporalAdapter, WaitsForPosesThatAreGiven) {
  TemporalConfig config = LoadConfig({}).temporal();
  config.set_motion(TemporalConfig::CHANNEL);
  TemporalAdapter adapter(config);
  EXPECT_TRUE(adapter.Inputs().Has(Part::kOdometry));
  for (int64_t seq = 0; seq < 3; ++seq) {
    Frame frame = FrameAt(seq);
    frame.odometry.emplace().start_from_left = MovedBy(0.01 * double(seq), 0, 0);
    frame.odometry->start_seq = seq / 2;  // the third is from elsewhere
    const std::string reason = AddAnswer(adapter, frame);
    EXPECT_EQ(frame.motion->reset, seq == 0   ? MemoryReset::kFirst
                                   : seq == 1 ? MemoryReset::kNone
                                              : MemoryReset::kFewPoints);
    EXPECT_THAT(reason, HasSubstr(seq < 2 ? "" : "SPROUT_ODOMETRY has no pose in the frame"));
  }
  Frame far = FrameAt(3);
  far.odometry.emplace().start_from_left = MovedBy(1e200, 0, 0);
  far.odometry->start_seq = 1;
  EXPECT_THAT(AddAnswer(adapter, far), HasSubstr("poses on SPROUT_ODOMETRY lie too far apart"));
}

TEST(TemporalAdapter, RefusesPartsOfDifferentSizes) {
  TemporalAdapter adapter(LoadConfig({}).temporal());
  Frame frame = FrameAt(0);
  EXPECT_EQ(AddAnswer(adapter, frame), "");
  Frame bad = FrameAt(1);
  bad.disparity = DisparityImage(cv::Size(5, 4));
  EXPECT_THAT(AddAnswer(adapter, bad), HasSubstr("DISPARITY of 5x4"));
  EXPECT_EQ(bad.fused->CountValid(), 0);
  bad = FrameAt(1);
  bad.confidence = cv::Mat();
  EXPECT_THAT(AddAnswer(adapter, bad), HasSubstr("CONFIDENCE"));
  // Nothing is remembered of them.
  frame = FrameAt(2);
  EXPECT_EQ(AddAnswer(adapter, frame), "");
  EXPECT_EQ(frame.motion->last_seq, 0);
}

TEST(ConfidenceScale, GoesThereAndBack) {
  const ConfidenceScale scale;
  for (int confidence = 0; confidence < 256; ++confidence) {
    const float variance = scale.variances()[static_cast<size_t>(confidence)];
    EXPECT_EQ(scale.ConfidenceOf(variance), confidence);
  }
  EXPECT_EQ(scale.ConfidenceOf(0.01F), 255);
  EXPECT_EQ(scale.ConfidenceOf(1e6F), 0);
}

}  // namespace
}  // namespace sprout::temporal
