#include "common/app/replay_input.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "common/logfile/log_error.h"
#include "tests/common/app/captured_log.h"
#include "tests/common/app/log_files.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class ReplayInputTest : public ::testing::Test {
 protected:
  std::string Write(const char* name, const std::vector<TestEvent>& events) {
    const std::string path = folder_ / name;
    WriteLog(path, events);
    return path;
  }

  // "channel@utime" of every event.
  static std::vector<std::string> Names(const std::vector<std::string>& logs,
                                        std::set<std::string, std::less<>> ordering = {}) {
    ReplayInput input(logs, "", std::move(ordering));
    std::vector<std::string> names;
    LogEvent event;
    while (input.Next(event)) {
      names.push_back(std::string(event.channel) + "@" + std::to_string(event.utime));
    }
    return names;
  }

  CapturedLog log_;
  TemporaryDirectory folder_;
};

TEST_F(ReplayInputTest, KeepsTheOrderOfOneLogWhateverItsTimes) {
  EXPECT_THAT(Names({Write("a", {{5, "A", {}}, {3, "B", {}}, {4, "A", {1}}})}),
              ElementsAre("A@5", "B@3", "A@4"));
}

TEST_F(ReplayInputTest, MergesByTimeAndAtOneTimeInTheOrderOfTheLogs) {
  const std::string a = Write("a", {{1, "A", {}}, {5, "A", {}}, {9, "A", {}}});
  const std::string b = Write("b", {{1, "B", {}}, {5, "B", {}}, {7, "B", {}}});
  EXPECT_THAT(Names({a, b}), ElementsAre("A@1", "B@1", "A@5", "B@5", "B@7", "A@9"));
  EXPECT_THAT(Names({b, a}), ElementsAre("B@1", "A@1", "B@5", "A@5", "B@7", "A@9"));
}

// Two parts of one recording, in either order.
TEST_F(ReplayInputTest, SaysWhatIsLeftOutOfOtherFrames) {
  const std::string a = Write("a", {LeftEvent(0, 10), LeftEvent(1, 11)});
  const std::string b = Write("b", {LeftEvent(2, 12), LeftEvent(3, 13)});
  for (const std::vector<std::string>& logs : {std::vector{a, b}, {b, a}}) {
    ReplayInput input(logs, "", {"SPROUT_LEFT"});
    for (LogEvent event; input.Next(event);) {
    }
    EXPECT_THAT(input.LeftOut(),
                ElementsAre(logs[0] + ": 2 messages on SPROUT_LEFT are not used: a later --replay "
                                      "has that channel, of other frames; `sprout-log merge` "
                                      "joins the parts of a recording"));
  }
}

// Their times overlap, as behind a step of the clock; or all of one log is left out.
TEST_F(ReplayInputTest, SaysWhatIsLeftOutOfFramesOfTheSameTime) {
  const auto left = [](int64_t seq, int64_t utime) {
    return TestEvent{utime, "SPROUT_LEFT",
                     EncodePart({.utime = utime, .seq = seq, .rig_id = "a"}, Part::kLeft,
                                cv::Mat1b(2, 3, uint8_t{1}))};
  };
  const auto left_out = [&](const std::vector<TestEvent>& a, const std::vector<TestEvent>& b) {
    ReplayInput input({Write("a", a), Write("b", b)}, "", {"SPROUT_LEFT", "SPROUT_RIGHT"});
    for (LogEvent event; input.Next(event);) {
    }
    return input.LeftOut();
  };
  const auto other_frames = ElementsAre(HasSubstr("has that channel, of other frames;"));
  EXPECT_THAT(left_out({left(0, 10), left(1, 20)}, {left(2, 10), left(3, 20)}), other_frames);
  EXPECT_THAT(left_out({left(0, 10), left(1, 20)}, {left(1, 20), left(2, 30)}), other_frames);
  // Answers that are named before the recording.
  EXPECT_THAT(
      left_out({left(0, 10), left(1, 20)}, {left(0, 10), left(1, 20), left(2, 30)}),
      ElementsAre(HasSubstr("a: nothing of it is used: a later --replay has SPROUT_LEFT;")));
  // Answers for a part of the frames, whose images stay.
  EXPECT_THAT(left_out({left(0, 10), RightEvent(0), left(1, 20)}, {left(1, 20)}), IsEmpty());
}

TEST_F(ReplayInputTest, SaysWhatIsLeftOutOfAnotherRig) {
  TestEvent other = LeftEvent(0, 10);
  FrameId id = TestId(0);
  id.rig_id = "other";
  other.data = EncodePart(id, Part::kLeft, cv::Mat(2, 3, CV_8UC1, cv::Scalar(10)));
  const auto left_out = [&](const TestEvent& a, const TestEvent& b) {
    ReplayInput input({Write("a", {a, RightEvent(0)}), Write("b", {b})}, "",
                      {"SPROUT_LEFT", "SPROUT_RIGHT"});
    for (LogEvent event; input.Next(event);) {
    }
    return input.LeftOut().size();
  };
  EXPECT_EQ(left_out(LeftEvent(0, 10), other), 1);
  EXPECT_EQ(left_out(LeftEvent(0, 10), LeftEvent(0, 11)), 0);
}

TEST_F(ReplayInputTest, ALateEventWaitsForThoseBeforeItButNotForOnesThatNobodyTakes) {
  const std::string a = Write("a", {{1, "A", {}}, {9, "X", {}}, {5, "A", {}}, {3, "A", {}}});
  const std::string b = Write("b", {{4, "B", {}}, {6, "B", {}}, {7, "B", {}}});
  EXPECT_THAT(Names({a, b}), ElementsAre("A@1", "B@4", "B@6", "B@7", "X@9", "A@5", "A@3"));
  EXPECT_THAT(Names({a, b}, {"A", "B"}),
              ElementsAre("A@1", "X@9", "B@4", "A@5", "A@3", "B@6", "B@7"));
}

TEST_F(ReplayInputTest, TakesAChannelFromTheLastLogThatHasIt) {
  const std::string raw = Write("raw", {{1, "LEFT", {}}, {2, "SEEDS", {}}, {3, "PRIOR", {}}});
  const std::string again = Write("again", {{8, "SEEDS", {}}});
  EXPECT_THAT(Names({raw, again}), ElementsAre("LEFT@1", "PRIOR@3", "SEEDS@8"));
  EXPECT_THAT(Names({again, raw}), ElementsAre("LEFT@1", "SEEDS@2", "PRIOR@3"));
}

TEST_F(ReplayInputTest, CountsEventsAndChannels) {
  ReplayInput input({Write("a", {{1, "A", {}}, {2, "B", {}}, {3, "A", {}}})});
  LogEvent event;
  while (input.Next(event)) {
  }
  EXPECT_EQ(input.events(), 3);
  EXPECT_EQ(input.channels().Text(), "A (2), B (1)");
  EXPECT_EQ(input.progress(), 1);
  EXPECT_EQ(input.damaged_bytes(), 0);
  EXPECT_THAT(log_.Lines(), IsEmpty());
}

TEST_F(ReplayInputTest, ReportsATornTail) {
  const std::string path = Write("a", {{1, "A", {1, 2, 3}}, {2, "A", {4, 5, 6}}});
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
  ReplayInput input({path});
  LogEvent event;
  EXPECT_TRUE(input.Next(event));
  EXPECT_FALSE(input.Next(event));
  EXPECT_GT(input.damaged_bytes(), 0);
  ASSERT_THAT(log_.Lines(), ::testing::SizeIs(1));
  EXPECT_THAT(log_.Lines()[0], ::testing::HasSubstr(path));
}

TEST_F(ReplayInputTest, RefusesWhatIsNoLog) {
  EXPECT_THROW(ReplayInput({std::string(folder_ / "missing")}), LogError);
  const std::string a = Write("a", {{1, "A", {}}});
  EXPECT_THROW(ReplayInput({a, std::string(folder_ / "missing")}), LogError);
}

}  // namespace
}  // namespace sprout
