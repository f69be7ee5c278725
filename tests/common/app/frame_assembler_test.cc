#include "common/app/frame_assembler.h"

#include <gmock/gmock.h>

#include "common/messages/codec.h"
#include "tests/common/app/captured_log.h"
#include "tests/common/messages/examples.h"

namespace sprout {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

std::vector<uint8_t> Image(int64_t seq, int grey) {
  return EncodePart({.utime = seq, .seq = seq, .rig_id = "rig"}, Part::kLeft,
                    cv::Mat(2, 3, CV_8UC1, cv::Scalar(grey)));
}

std::vector<uint8_t> Seeds(int64_t seq) {
  return EncodePart({.utime = seq, .seq = seq, .rig_id = "rig"}, Part::kSeeds,
                    SeedSet{.seeds = {{3, 2, 1}}, .raw = 1});
}

class FrameAssemblerTest : public ::testing::Test {
 protected:
  CapturedLog log_;
  StageMonitor monitor_{"grow", ""};
  FrameAssembler assembler_{{Part::kSeeds, Part::kLeft}, monitor_};
};

std::vector<uint8_t> CompressedPrior(int64_t seq, cv::Size size) {
  return EncodePart({.utime = seq, .seq = seq, .rig_id = "rig"}, Part::kPrior, PriorMap(size),
                    DisparityEncoding::kDeltaZstd);
}

TEST(FrameAssembler, RefusesACompressedMapThatDoesNotFitTheFramesImages) {
  CapturedLog log;
  StageMonitor monitor("grow", "");
  FrameAssembler assembler({Part::kLeft, Part::kPrior}, monitor);
  assembler.Add("SPROUT_LEFT", Image(3, 99));
  EXPECT_THAT(assembler.Add("SPROUT_PRIOR", CompressedPrior(3, {3000, 2000})), IsEmpty());
  EXPECT_THAT(monitor.Snapshot().last_error, HasSubstr("size of the frame's images, 3x2"));
  EXPECT_THAT(assembler.Add("SPROUT_PRIOR", CompressedPrior(3, {3, 2})), SizeIs(1));
}

TEST_F(FrameAssemblerTest, ListsTheChannelsOfItsParts) {
  EXPECT_THAT(assembler_.channels(), ElementsAre("SPROUT_LEFT", "SPROUT_SEEDS"));
}

TEST_F(FrameAssemblerTest, DeliversAFrameOnceItIsComplete) {
  EXPECT_THAT(assembler_.Add("SPROUT_LEFT", Image(3, 99)), IsEmpty());
  const std::vector<Frame> frames = assembler_.Add("SPROUT_SEEDS", Seeds(3));
  ASSERT_THAT(frames, SizeIs(1));
  EXPECT_EQ(frames[0].id, (FrameId{.utime = 3, .seq = 3, .rig_id = "rig"}));
  EXPECT_EQ(frames[0].left.at<uint8_t>(1, 2), 99);
  EXPECT_THAT(frames[0].seeds->seeds, ElementsAre(Seed{3, 2, 1}));
  EXPECT_EQ(monitor_.Snapshot().bad_messages, 0);
}

TEST_F(FrameAssemblerTest, CountsAndNamesABadMessage) {
  std::vector<uint8_t> cut = Image(3, 99);
  cut.pop_back();
  EXPECT_THAT(assembler_.Add("SPROUT_LEFT", cut), IsEmpty());
  EXPECT_THAT(assembler_.Add("SPROUT_LEFT", {}), IsEmpty());
  EXPECT_EQ(monitor_.Snapshot().bad_messages, 2);
  EXPECT_THAT(monitor_.Snapshot().last_error, StartsWith("SPROUT_LEFT: "));
  EXPECT_THAT(assembler_.Add("SPROUT_SEEDS", Image(3, 99)), IsEmpty());
  EXPECT_THAT(monitor_.Snapshot().last_error, "SPROUT_SEEDS: fingerprint is not that of seeds_t");
}

TEST_F(FrameAssemblerTest, KeepsTheFirstOfTwoAnswersAndCountsTheOther) {
  assembler_.Add("SPROUT_SEEDS", Seeds(3));
  assembler_.Add("SPROUT_SEEDS", EncodePart({.utime = 3, .seq = 3, .rig_id = "rig"}, Part::kSeeds,
                                            SeedSet{.seeds = {{3, 1, 1}}, .raw = 1}));
  EXPECT_EQ(monitor_.Snapshot().bad_messages, 1);
  EXPECT_THAT(monitor_.Snapshot().last_error,
              StartsWith("SPROUT_SEEDS: frame 3 has two that differ, the first counts"));
  const std::vector<Frame> frames = assembler_.Add("SPROUT_LEFT", Image(3, 99));
  ASSERT_THAT(frames, SizeIs(1));
  EXPECT_THAT(frames[0].seeds->seeds, ElementsAre(Seed{3, 2, 1}));
  assembler_.Add("SPROUT_LEFT", Image(3, 98));  // the frame is complete and gone
  EXPECT_EQ(monitor_.Snapshot().bad_messages, 2);
}

TEST(FrameAssembler, SaysThatACalibrationChangedUnderItsName) {
  CapturedLog log;
  StageMonitor monitor("grow", "");
  FrameAssembler assembler({Part::kLeft, Part::kRig}, monitor);
  const auto add = [&](int64_t seq, double focal_px) {
    Rig rig = examples::Rig();
    rig.pair.focal_px = focal_px;
    const FrameId id{.utime = seq, .seq = seq, .rig_id = "1"};
    assembler.Add("SPROUT_RIG", EncodePart(id, Part::kRig, rig));
  };
  for (const int64_t seq : {0, 1}) add(seq, 500);
  EXPECT_EQ(monitor.Snapshot().last_error, "");
  for (const int64_t seq : {2, 3}) add(seq, 520);
  EXPECT_THAT(monitor.Snapshot().last_error,
              StartsWith("SPROUT_RIG: rig_id '1' again, with other"));
  EXPECT_THAT(log.Lines(), SizeIs(1));
}

void AddLeftAndTof(FrameAssembler& assembler, int64_t utime, int64_t seq) {
  const FrameId id{.utime = utime, .seq = seq, .rig_id = ""};
  assembler.Add("SPROUT_LEFT", EncodePart(id, Part::kLeft, cv::Mat1b(2, 3, uint8_t{1})));
  assembler.Add("SPROUT_TOF", EncodePart(id, Part::kTof, examples::Tof(false)));
}

// capture --loop of a bag gives new numbers to the old times.
TEST(FrameAssembler, KnowsARecordingThatPlaysInALoop) {
  const CapturedLog log;
  StageMonitor monitor("refine", "");
  FrameAssembler assembler({Part::kLeft, Part::kTof}, monitor);
  for (int64_t seq = 0; seq < 40; ++seq) AddLeftAndTof(assembler, 100 + seq % 5, seq);
  EXPECT_THAT(log.Lines(), IsEmpty());
  // The µs of a second alone.
  for (int64_t seq = 40; seq < 60; ++seq) AddLeftAndTof(assembler, 200 + 101 * seq % 500, seq);
  EXPECT_THAT(monitor.Snapshot().last_error, HasSubstr("utime does not rise"));
}

TEST(FrameAssembler, SaysThatTimesDoNotRiseWhereTheToFImageIsJoined) {
  CapturedLog log;
  const auto& add = AddLeftAndTof;
  StageMonitor monitor("refine", "");
  FrameAssembler assembler({Part::kLeft, Part::kTof}, monitor);
  for (const int64_t seq : {0, 1}) add(assembler, 7, seq);
  EXPECT_EQ(monitor.Snapshot().last_error, "") << "a clock that was set back once";
  for (int64_t seq = 2; seq < 200; ++seq) add(assembler, 7, seq);
  EXPECT_THAT(monitor.Snapshot().last_error, StartsWith("frame 2: utime does not rise"));
  EXPECT_THAT(log.Lines(), SizeIs(1));
  for (int64_t seq = 200; seq < 301; ++seq) add(assembler, 7 + seq, seq);
  EXPECT_EQ(monitor.Snapshot().last_error, "");
  StageMonitor later("grow", "");
  FrameAssembler without({Part::kLeft}, later);
  for (int64_t seq = 0; seq < 5; ++seq) add(without, 7, seq);
  EXPECT_EQ(later.Snapshot().last_error, "");
}

TEST_F(FrameAssemblerTest, DeliversAFrameTwiceThatIsSentTwice) {
  for (int i = 0; i < 2; ++i) {
    assembler_.Add("SPROUT_LEFT", Image(3, 99));
    EXPECT_THAT(assembler_.Add("SPROUT_SEEDS", Seeds(3)), SizeIs(1));
  }
  EXPECT_EQ(monitor_.Snapshot().bad_messages, 0);
}

TEST_F(FrameAssemblerTest, IgnoresAChannelThatItDoesNotNeed) {
  EXPECT_THAT(assembler_.Add("SPROUT_TOF", std::vector<uint8_t>(100, 7)), IsEmpty());
  EXPECT_THAT(assembler_.Add("SPROUT_RIGHT", Image(3, 1)), IsEmpty());
  EXPECT_THAT(assembler_.Add("", Image(3, 1)), IsEmpty());
  EXPECT_THAT(assembler_.Add("SPROUT_LEFT_2", Image(3, 1)), IsEmpty());
  EXPECT_EQ(monitor_.Snapshot().bad_messages, 0);
}

TEST_F(FrameAssemblerTest, ReportsWhatTheJoinerDropsAndMisses) {
  assembler_.Add("SPROUT_LEFT", Image(1, 1));
  assembler_.Add("SPROUT_LEFT", Image(4, 1));
  assembler_.Add("SPROUT_SEEDS", Seeds(4));
  EXPECT_EQ(monitor_.Snapshot().frames_incomplete, 1);
  EXPECT_EQ(monitor_.Snapshot().sequence_gaps, 2);
}

TEST_F(FrameAssemblerTest, CountsWhatIsUnfinishedAtTheEnd) {
  assembler_.Add("SPROUT_LEFT", Image(1, 1));
  assembler_.Add("SPROUT_SEEDS", Seeds(2));
  assembler_.Finish();
  EXPECT_EQ(monitor_.Snapshot().frames_incomplete, 2);
  assembler_.Finish();
  EXPECT_EQ(monitor_.Snapshot().frames_incomplete, 2);
}

}  // namespace
}  // namespace sprout
