#include "common/frames/log_frames.h"

#include <gmock/gmock.h>

#include "common/logfile/log_error.h"
#include "tests/common/app/log_files.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class LogFramesTest : public ::testing::Test {
 protected:
  std::vector<Frame> Read(const std::vector<TestEvent>& events, FrameChoice choice = {}) {
    WriteLog(path_, events);
    return ReadFile(std::move(choice));
  }

  std::vector<Frame> ReadFile(FrameChoice choice = {}) {
    LogFrames log(path_, std::move(choice), [this](const LogEvent& event, const std::string& why) {
      refused_.push_back(std::string(event.channel) + ": " + why);
    });
    std::vector<Frame> frames;
    while (auto frame = log.Next([this](int64_t position) { position_ = position; })) {
      frames.push_back(std::move(*frame));
    }
    EXPECT_FALSE(log.Next());
    damage_ = log.log().damage();
    return frames;
  }

  static std::vector<int64_t> Seqs(const std::vector<Frame>& frames) {
    std::vector<int64_t> seqs;
    for (const Frame& frame : frames) seqs.push_back(frame.id.seq);
    return seqs;
  }

  TemporaryDirectory folder_;
  std::string path_ = folder_ / "in.lcm";
  std::vector<std::string> refused_;
  std::vector<LogDamage> damage_;
  int64_t position_ = 0;
};

TEST_F(LogFramesTest, GivesWhatIsThereOfEachFrameInTheOrderOfTheLog) {
  const auto frames = Read({TofEvent(4), LeftEvent(5, 50), RightEvent(4), SeedsEvent(5, 9)});
  ASSERT_THAT(Seqs(frames), ElementsAre(4, 5));
  EXPECT_TRUE(frames[0].tof.has_value());
  EXPECT_EQ(frames[0].right.size(), cv::Size(3, 2));
  EXPECT_TRUE(frames[0].left.empty());
  EXPECT_EQ(frames[1].left.at<uint8_t>(0, 0), 50);
  EXPECT_EQ(frames[1].seeds->raw, 9);
  EXPECT_FALSE(frames[1].rig.has_value());
  EXPECT_EQ(position_, static_cast<int64_t>(std::filesystem::file_size(path_)));
}

TEST_F(LogFramesTest, RefusesTwoAnswersForOneFrameUnlessTheyAreOne) {
  const std::vector<TestEvent> same = {LeftEvent(4, 1), SeedsEvent(4, 9), SeedsEvent(4, 9)};
  EXPECT_EQ(Read(same).at(0).seeds->raw, 9);
  const std::vector<TestEvent> two = {LeftEvent(4, 1), SeedsEvent(4, 8), LeftEvent(5, 1),
                                      SeedsEvent(4, 9)};
  EXPECT_THAT(Thrown<LogError>([&] { Read(two); }),
              HasSubstr("two answers for frame 4: SPROUT_SEEDS at bytes "));
  // Nobody is misled by what is not read.
  EXPECT_THAT(Seqs(Read(two, {.parts = {Part::kLeft}})), ElementsAre(4, 5));
}

TEST_F(LogFramesTest, HasTheAnswersOfStagesThatLagFiftyFramesBehind) {
  std::vector<TestEvent> events;
  for (int64_t seq = 0; seq < 100; ++seq) {
    events.push_back(LeftEvent(seq, static_cast<int>(seq)));
    if (seq >= 50) events.push_back(SeedsEvent(seq - 50, static_cast<int>(seq)));
  }
  const auto frames = Read(events);
  ASSERT_EQ(frames.size(), 100U);
  for (size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(frames[i].left.at<uint8_t>(0, 0), i);
    EXPECT_EQ(frames[i].seeds.has_value(), i < 50) << i;
  }
}

TEST_F(LogFramesTest, KnowsACalibrationThatStandsFurtherOn) {
  const auto frames =
      Read({LeftEvent(0, 1), LeftEvent(1, 1), LeftEvent(2, 1), RigEvent(3)}, {.look_back = 1});
  ASSERT_THAT(Seqs(frames), ElementsAre(0, 1, 2));
  for (const Frame& frame : frames) EXPECT_EQ(RigId(frame.rig.value()), frame.id.rig_id);
}

TEST_F(LogFramesTest, TellsAndLeavesOutWhatCannotBeDecoded) {
  TestEvent torn = LeftEvent(1, 1);
  torn.data.pop_back();
  TestEvent alone = torn;
  alone.data = LeftEvent(2, 1).data;
  alone.data.pop_back();
  const auto frames = Read({LeftEvent(0, 1), torn, RightEvent(1), alone, LeftEvent(3, 1)});
  EXPECT_THAT(Seqs(frames), ElementsAre(0, 1, 3));
  EXPECT_TRUE(frames[1].left.empty());
  EXPECT_FALSE(frames[1].right.empty());
  EXPECT_THAT(refused_, ElementsAre(HasSubstr("SPROUT_LEFT: "), HasSubstr("SPROUT_LEFT: ")));
}

TEST_F(LogFramesTest, GoesOnBehindDamage) {
  WriteLog(path_, {LeftEvent(0, 1), LeftEvent(1, 1)});
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 1);
  EXPECT_THAT(Seqs(ReadFile()), ElementsAre(0));
  ASSERT_EQ(damage_.size(), 1U);
  EXPECT_TRUE(damage_[0].tail);
  EXPECT_THAT(refused_, ::testing::IsEmpty());
}

}  // namespace
}  // namespace sprout
