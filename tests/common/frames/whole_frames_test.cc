#include <gmock/gmock.h>

#include "common/frames/log_frames.h"
#include "common/logfile/log_reader.h"
#include "tests/common/app/log_files.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout {
namespace {

using ::testing::ElementsAre;

const PartSet kNeeded{Part::kLeft, Part::kTof};

class WholeFramesTest : public ::testing::Test {
 protected:
  WholeFrames Open(const std::vector<TestEvent>& events, PartSet needed = kNeeded) {
    WriteLog(path_, events);
    return {path_, "", needed, [this](const LogEvent& event, const std::string& /*why*/) {
              refused_.emplace_back(event.channel);
            }};
  }

  static std::vector<int64_t> Seqs(WholeFrames& log) {
    std::vector<int64_t> seqs;
    while (const auto next = log.Next()) seqs.push_back(next->frame.id.seq);
    return seqs;
  }

  std::vector<uint8_t> BytesAt(int64_t offset) {
    EventFetcher fetcher(path_);  // has the bytes
    const LogEvent event = fetcher.Fetch(offset);
    return {event.data.begin(), event.data.end()};
  }

  TemporaryDirectory folder_;
  std::string path_ = folder_ / "in.lcm";
  std::vector<std::string> refused_;
};

TEST_F(WholeFramesTest, SaysWhereTheMessagesOfAFrameStand) {
  WholeFrames log = Open({LeftEvent(0, 1), LeftEvent(1, 9), TofEvent(1), LeftEvent(2, 5),
                          LeftEvent(2, 6), SeedsEvent(2, 1), TofEvent(2)});
  const auto first = log.Next();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->frame.id, TestId(1));
  EXPECT_EQ(first->frame.left.at<uint8_t>(0, 0), 9);
  EXPECT_EQ(first->places.id, TestId(1));
  EXPECT_EQ(BytesAt(first->places.offset(Part::kLeft)), LeftEvent(1, 9).data);
  EXPECT_EQ(BytesAt(first->places.offset(Part::kTof)), TofEvent(1).data);
  const auto second = log.Next();
  ASSERT_TRUE(second);
  EXPECT_EQ(BytesAt(second->places.offset(Part::kLeft)), LeftEvent(2, 6).data);
  EXPECT_FALSE(second->places.Has(Part::kSeeds));
  EXPECT_FALSE(log.Next());
}

TEST_F(WholeFramesTest, CountsWhatIsNotWholeAndWhatIsRefused) {
  TestEvent torn = TofEvent(1);
  torn.data.pop_back();
  WholeFrames log =
      Open({LeftEvent(0, 1), LeftEvent(1, 1), torn, LeftEvent(4, 1), TofEvent(4), LeftEvent(5, 1)});
  EXPECT_THAT(Seqs(log), ElementsAre(4));
  EXPECT_EQ(log.joiner().incomplete(), 3);
  EXPECT_EQ(log.joiner().sequence_gaps(), 2);
  EXPECT_THAT(refused_, ElementsAre("SPROUT_TOF"));
  EXPECT_EQ(log.channels().Text(), "SPROUT_LEFT (4), SPROUT_TOF (2)");
}

TEST_F(WholeFramesTest, GivesAFrameThatWasSentTwiceTwiceEachWithItsOwnMessages) {
  WholeFrames log = Open({LeftEvent(0, 1), TofEvent(0), LeftEvent(0, 2), TofEvent(0)});
  const auto first = log.Next();
  const auto second = log.Next();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(BytesAt(first->places.offset(Part::kLeft)), LeftEvent(0, 1).data);
  EXPECT_EQ(BytesAt(second->places.offset(Part::kLeft)), LeftEvent(0, 2).data);
}

TEST_F(WholeFramesTest, GivesAllFramesThatALateCalibrationCompletes) {
  const std::vector<TestEvent> events = {LeftEvent(0, 1), LeftEvent(1, 1), RigEvent(2),
                                         LeftEvent(2, 1)};
  WholeFrames log = Open(events, {Part::kLeft, Part::kRig});
  const auto first = log.Next();
  ASSERT_TRUE(first);
  EXPECT_EQ(RigId(first->frame.rig.value()), TestId(0).rig_id);
  EXPECT_EQ(BytesAt(log.newest_rig().value()), RigEvent(2).data);
  EXPECT_THAT(Seqs(log), ElementsAre(1, 2));
}

TEST_F(WholeFramesTest, TakesACalibrationThatHoldsFromTheStart) {
  WholeFrames log = Open({LeftEvent(0, 1)}, {Part::kLeft, Part::kRig});
  log.AddRig(RigEvent(0).data);
  EXPECT_THAT(Seqs(log), ElementsAre(0));
  EXPECT_EQ(log.newest_rig(), std::nullopt);
}

}  // namespace
}  // namespace sprout
