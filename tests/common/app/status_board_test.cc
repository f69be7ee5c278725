#include "common/app/status_board.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace sprout {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class StatusBoardTest : public ::testing::Test {
 protected:
  static StageStatus Status(const std::string& stage, int32_t pid = 1) {
    StageStatus status;
    status.stage = stage;
    status.host = "robot";
    status.pid = pid;
    status.state = StageStatus::State::kRunning;
    return status;
  }

  std::vector<std::string> Seen(milliseconds after = milliseconds(0)) const {
    std::vector<std::string> seen;
    for (const BoardRow& row : board_.Rows(start_ + after)) {
      seen.push_back(row.status.stage + " " + std::string(NameOf(row.health)));
    }
    return seen;
  }

  bool Whole(milliseconds after = milliseconds(0)) const {
    return IsWhole(board_.Rows(start_ + after));
  }

  StatusBoard::Clock::time_point start_{};
  StatusBoard board_{{"capture", "grow"}};
};

TEST_F(StatusBoardTest, MissesTheStagesThatNobodyHeard) {
  EXPECT_THAT(Seen(), ElementsAre("capture missing", "grow missing"));
  EXPECT_THAT(BoardText(board_.Rows(start_), false), HasSubstr("\nnothing is heard: is the graph"));
  board_.Add(Status("grow"), start_);
  EXPECT_THAT(Seen(), ElementsAre("capture missing", "grow good"));
  EXPECT_THAT(BoardText(board_.Rows(start_), false), Not(HasSubstr("nothing is heard")));
  EXPECT_FALSE(Whole());
  board_.Add(Status("capture"), start_);
  EXPECT_TRUE(Whole());
}

TEST_F(StatusBoardTest, ShowsWhatATerminalWouldObey) {
  StageStatus status = Status("gr\x1b[2Jow");
  status.host = "robot\n";
  status.last_error = "no\r\x1b]0;damage";
  board_.Add(status, start_);
  const std::string text = BoardText(board_.Rows(start_), /*colour=*/false);
  EXPECT_THAT(text, HasSubstr("gr\\x1b[2Jow"));
  EXPECT_THAT(text, HasSubstr("robot\\x0a:1"));
  EXPECT_THAT(text, HasSubstr("no\\x0d\\x1b]0;damage"));
}

TEST_F(StatusBoardTest, ListsOthersBehindTheExpectedOnes) {
  for (const char* stage : {"view", "grow", "depth", "capture"}) board_.Add(Status(stage), start_);
  EXPECT_THAT(Seen(), ElementsAre("capture good", "grow good", "depth good", "view good"));
}

TEST_F(StatusBoardTest, SaysWhoFellSilentAndWhoStopped) {
  board_.Add(Status("capture"), start_);
  board_.Add(Status("grow"), start_);
  EXPECT_TRUE(Whole(milliseconds(3400)));
  board_.Add(Status("grow"), start_ + milliseconds(3000));
  EXPECT_THAT(Seen(milliseconds(3600)), ElementsAre("capture stale", "grow good"));
  StageStatus stopped = Status("grow");
  stopped.state = StageStatus::State::kStopped;
  board_.Add(stopped, start_ + milliseconds(4000));
  EXPECT_THAT(Seen(milliseconds(4000)), ElementsAre("capture stale", "grow stopped"));
  EXPECT_FALSE(Whole(milliseconds(4000)));
}

TEST_F(StatusBoardTest, NoticesTwoProcessesOfOneStageButNotASuccessor) {
  board_.Add(Status("capture"), start_);
  board_.Add(Status("grow", 1), start_);
  board_.Add(Status("grow", 2), start_);
  EXPECT_THAT(Seen(), ElementsAre("capture good", "grow twice", "grow twice"));
  EXPECT_FALSE(Whole());
  board_.Add(Status("capture"), start_ + milliseconds(3600));
  board_.Add(Status("grow", 2), start_ + milliseconds(3600));
  EXPECT_THAT(Seen(milliseconds(3600)), ElementsAre("capture good", "grow good"));
}

TEST_F(StatusBoardTest, IsWholeWhateverTheOthersDo) {
  board_.Add(Status("capture"), start_);
  board_.Add(Status("grow"), start_);
  board_.Add(Status("view", 1), start_);
  board_.Add(Status("view", 2), start_);
  StageStatus stopped = Status("depth");
  stopped.state = StageStatus::State::kStopped;
  board_.Add(stopped, start_);
  EXPECT_THAT(Seen(), ElementsAre("capture good", "grow good", "depth stopped", "view twice",
                                  "view twice"));
  EXPECT_TRUE(Whole());
  EXPECT_TRUE(nlohmann::json::parse(BoardJson(board_.Rows(start_)))["whole"]);
}

TEST_F(StatusBoardTest, ShowsOfAStageThatEndedOnlyTheProcessThatWasHeardLast) {
  const auto stop = [&](int32_t pid, milliseconds after) {
    StageStatus status = Status("grow", pid);
    status.state = StageStatus::State::kStopped;
    board_.Add(status, start_ + after);
  };
  board_.Add(Status("capture"), start_ + milliseconds(5000));
  board_.Add(Status("grow", 3), start_);  // killed: it said nothing more
  stop(2, milliseconds(1000));
  stop(1, milliseconds(5000));
  EXPECT_THAT(Seen(milliseconds(5000)), ElementsAre("capture good", "grow stopped"));
  EXPECT_EQ(board_.Rows(start_ + milliseconds(5000)).back().status.pid, 1);
}

TEST_F(StatusBoardTest, SaysWhoLosesNow) {
  StageStatus status = Status("grow");
  status.frames_skipped = 5;
  board_.Add(status, start_);
  EXPECT_THAT(Seen(), ElementsAre("capture missing", "grow good"));
  ++status.frames_skipped;
  board_.Add(status, start_);
  EXPECT_THAT(Seen(), ElementsAre("capture missing", "grow losing"));
  board_.Add(status, start_ + milliseconds(59'000));
  EXPECT_THAT(Seen(milliseconds(59'000)), ElementsAre("capture missing", "grow losing"));
  board_.Add(status, start_ + milliseconds(60'000));
  EXPECT_THAT(Seen(milliseconds(60'000)), ElementsAre("capture missing", "grow good"));
}

TEST_F(StatusBoardTest, TellsHowLongAgoAnErrorCameUntilItIsOver) {
  const auto text_at = [&](milliseconds after) {
    return BoardText(board_.Rows(start_ + after), /*colour=*/false);
  };
  StageStatus status = Status("grow");
  board_.Add(status, start_);
  status.last_error = "no whole frame";
  board_.Add(status, start_ + milliseconds(5000));
  EXPECT_THAT(text_at(milliseconds(12'000)), HasSubstr("grow, 7 s ago: no whole frame"));
  status.last_error = "";
  board_.Add(status, start_ + milliseconds(13'000));
  EXPECT_THAT(text_at(milliseconds(13'000)), Not(HasSubstr("no whole frame")));

  // What is true for hours is shown for hours, though its text never changes.
  status.last_error = "another sprout-grow";
  for (int second = 20; second < 7300; ++second) {
    ++status.frames_out;
    board_.Add(status, start_ + std::chrono::seconds(second));
  }
  EXPECT_THAT(text_at(std::chrono::seconds(7300)), HasSubstr("grow, 2.0 h ago: another sprout-gr"));
}

TEST_F(StatusBoardTest, ShowsAnOffsetOfTheToFCameraOnlyWhenItIsSignificant) {
  StageStatus status = Status("grow");
  status.tof_offset = {.u_px = 0.3F, .v_px = -1.7F, .sigma_px = 1.7F};
  board_.Add(status, start_);
  EXPECT_THAT(BoardText(board_.Rows(start_), false), Not(HasSubstr("off by")));
  status.tof_offset.sigma_px = 0.4F;
  board_.Add(status, start_);
  EXPECT_THAT(BoardText(board_.Rows(start_), false),
              HasSubstr("ToF points off by (-0.3, 1.7) ± 0.4 px, and edges of depth with them: "
                        "calibrate again"));
}

TEST_F(StatusBoardTest, SaysThatStagesOfOneMapHaveDifferentConfigurations) {
  const auto add = [&](const char* stage, const char* digest) {
    StageStatus status = Status(stage);
    status.config_digest = digest;
    board_.Add(status, start_);
  };
  add("capture", "has a source");
  add("depth", "has limits");
  add("prior", "a");
  add("grow", "a");
  add("refine", "");  // a program that does not say it
  EXPECT_THAT(BoardText(board_.Rows(start_), false), Not(HasSubstr("configurations")));
  EXPECT_EQ(nlohmann::json::parse(BoardJson(board_.Rows(start_)))["configurations"], "");
  add("refine", "b\x1b");
  EXPECT_THAT(BoardText(board_.Rows(start_), false),
              HasSubstr("\nconfigurations differ: grow, prior: a; refine: b\\x1b\n"));
  EXPECT_EQ(nlohmann::json::parse(BoardJson(board_.Rows(start_)))["configurations"],
            "configurations differ: grow, prior: a; refine: b\\x1b");
}

TEST_F(StatusBoardTest, CallsFramesOfARecordingOld) {
  StageStatus status = Status("grow");
  status.age = {.p50_ms = 327'000, .p95_ms = 328'000, .p99_ms = 328'368, .max_ms = 328'368};
  board_.Add(status, start_);
  const std::string text = BoardText(board_.Rows(start_), false);
  EXPECT_THAT(text, Not(HasSubstr("328368")));
  EXPECT_THAT(text, HasSubstr("old: captured more than 100 s ago, as frames of a recording are, "
                              "and those whose utime is not in µs since 1970\n"));
}

TEST_F(StatusBoardTest, KeepsNoMoreThan64Processes) {
  for (int pid = 0; pid < 64; ++pid) EXPECT_TRUE(board_.Add(Status("grow", pid), start_));
  EXPECT_FALSE(board_.Add(Status("grow", 64), start_));
  EXPECT_TRUE(board_.Add(Status("grow", 63), start_));
  EXPECT_EQ(board_.left_out().no_room, 1);
  EXPECT_EQ(board_.left_out().unreadable, 0) << "nothing was wrong with it";
}

TEST_F(StatusBoardTest, TellsStatusesThatCannotBeReadFromThoseWithoutRoom) {
  EXPECT_EQ(LeftOutText(board_.left_out()), "");
  for (int i = 0; i < 2; ++i) board_.AddUnreadable();
  EXPECT_EQ(LeftOutText(board_.left_out()), "2 statuses could not be read\n");
  for (int pid = 0; pid < 64 + 15; ++pid) board_.Add(Status("grow", pid), start_);
  EXPECT_EQ(LeftOutText(board_.left_out()),
            "2 statuses could not be read\n"
            "15 statuses of further processes are not shown: there is room for 64\n");
  LeftOut all = board_.left_out();
  all.not_joined = 3;
  EXPECT_THAT(LeftOutText(all), HasSubstr("\n3 times this host could not join the packets"));
  const auto json = nlohmann::json::parse(BoardJson(board_.Rows(start_), all));
  EXPECT_EQ(json["unreadable"], 2);
  EXPECT_EQ(json["no_room"], 15);
  EXPECT_EQ(json["not_joined"], 3);
  EXPECT_FALSE(nlohmann::json::parse(BoardJson({})).contains("no_room")) << "it is not known";
}

TEST_F(StatusBoardTest, MakesRoomForAStageThatIsStartedAgainAndAgain) {
  StageStatus stopped = Status("grow", 0);
  stopped.state = StageStatus::State::kStopped;
  EXPECT_TRUE(board_.Add(stopped, start_));
  for (int pid = 1; pid < 64; ++pid) EXPECT_TRUE(board_.Add(Status("grow", pid), start_));
  EXPECT_TRUE(board_.Add(Status("grow", 64), start_)) << "in place of the stopped one";
  const auto later = std::chrono::minutes(1);
  for (int pid = 100; pid < 110; ++pid) {
    EXPECT_TRUE(board_.Add(Status("grow", pid), start_ + later)) << "in place of a silent one";
  }
  EXPECT_TRUE(board_.Add(Status("capture"), start_ + later));
  EXPECT_EQ(board_.left_out().no_room, 0);
  EXPECT_EQ(Seen(later).front(), "capture good");
}

TEST_F(StatusBoardTest, IsWrittenForPeopleAndForScripts) {
  StageStatus status = Status("grow", 77);
  status.newest_frame.seq = 412;
  status.rate_hz = 9.96;
  status.last_error = "frame 3: failed: no \xff seeds";
  board_.Add(status, start_);
  const auto rows = board_.Rows(start_);
  const std::string text = BoardText(rows, /*colour=*/false);
  EXPECT_THAT(text, HasSubstr("capture    missing"));
  EXPECT_THAT(text, HasSubstr("grow       good       412   10.0"));
  EXPECT_THAT(text, HasSubstr("robot:77"));
  EXPECT_THAT(text, HasSubstr("grow, over 0 s ago: frame 3: failed"));
  EXPECT_THAT(text, Not(HasSubstr("\x1b")));
  EXPECT_THAT(BoardText(rows, /*colour=*/true), HasSubstr("\x1b[31mmissing"));

  const auto json = nlohmann::json::parse(BoardJson(rows));
  EXPECT_FALSE(json["whole"]);
  EXPECT_EQ(json["stages"][0]["health"], "missing");
  EXPECT_EQ(json["stages"][1]["newest_seq"], 412);
  EXPECT_EQ(json["stages"][1]["pid"], 77);
  status.rate_hz = 0.0934;
  board_.Add(status, start_);
  EXPECT_THAT(BoardText(board_.Rows(start_), false), HasSubstr(" 0.093 "));
}

TEST_F(StatusBoardTest, SaysWhichClocksTellAnAge) {
  StageStatus capture = Status("capture");
  capture.host = "eyes";
  StageStatus grow = Status("grow");
  grow.host = "brain";
  grow.age.p50_ms = 120;
  board_.Add(capture, start_);
  board_.Add(grow, start_);
  auto rows = board_.Rows(start_);
  EXPECT_THAT(BoardText(rows, false), HasSubstr(" ~120 "));
  EXPECT_THAT(BoardText(rows, false), HasSubstr("~: compares the clocks of two hosts"));
  EXPECT_EQ(nlohmann::json::parse(BoardJson(rows))["stages"][0]["age_clocks"], "one");
  EXPECT_EQ(nlohmann::json::parse(BoardJson(rows))["stages"][1]["age_clocks"], "two");
  grow.age.p50_ms = -3'600'000;
  board_.Add(grow, start_);
  rows = board_.Rows(start_);
  EXPECT_THAT(BoardText(rows, false), HasSubstr(" ? "));
  EXPECT_EQ(nlohmann::json::parse(BoardJson(rows))["stages"][1]["age_clocks"], "wrong");
}

TEST_F(StatusBoardTest, SaysWhatTwoHostsNeedWhenAStageIsMissing) {
  EXPECT_THAT(BoardText(board_.Rows(start_), false), Not(HasSubstr("ttl=1"))) << "nobody is there";
  board_.Add(Status("grow"), start_);
  EXPECT_THAT(BoardText(board_.Rows(start_), false),
              HasSubstr("capture: not heard here; if on another host: ttl=1"));
}

}  // namespace
}  // namespace sprout
