#include "common/app/replay.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <stdexcept>

#include "common/app/version.h"
#include "common/core/digest.h"
#include "tests/common/app/captured_log.h"
#include "tests/common/app/log_files.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

// LEFT TOF RIG → SEEDS: how many raw points there were is the grey value of LEFT. Grey 0 gives a
// degenerate frame, grey 255 an exception.
class GreyAdapter : public StageAdapter {
 public:
  PartSet Inputs() const override { return {Part::kLeft, Part::kTof, Part::kRig}; }

  StageResult Process(const Frame& frame) override {
    seen.push_back(frame.id.seq);
    const int grey = frame.left.at<uint8_t>(0, 0);
    if (grey == 255) throw std::runtime_error("too bright");
    if (on_frame) on_frame();
    return {.outputs = {{Part::kSeeds, SeedSet{.seeds = {}, .raw = grey}}},
            .degenerate = grey == 0 ? "too dark" : ""};
  }

  int WarmUpFrames() const override { return warm_up; }

  std::function<void()> on_frame;
  std::vector<int64_t> seen;
  int warm_up = 0;
};

class ReplayTest : public ::testing::Test {
 protected:
  ReplayTest() : in_(folder_ / "in.lcm"), out_(folder_ / "out.lcm") {}

  int Run(FrameRange frames = {}, std::vector<std::string> logs = {}) {
    if (logs.empty()) logs = {in_};
    ServiceContext context{.stage = "grey",
                           .version = Version(),
                           .config = LoadConfig({}),
                           .lcm_url = "",
                           .prefix = prefix_,
                           .replay = {},
                           .stop = stop_.get_token()};
    ::testing::internal::CaptureStdout();
    try {
      const int code =
          RunReplay(context, {.logs = logs, .record = out_, .frames = frames}, adapter_);
      report_ = ::testing::internal::GetCapturedStdout();
      return code;
    } catch (...) {
      report_ = ::testing::internal::GetCapturedStdout();
      throw;
    }
  }

  // The answers, which stand behind what the process says of itself.
  std::vector<TestEvent> Answers() const {
    std::vector<TestEvent> events = ReadLog(out_);
    if (events.empty() || !DecodeProcessInfo(events.front().data)) {
      ADD_FAILURE() << "the log does not begin with SPROUT_PROCESS";
      return events;
    }
    events.erase(events.begin());
    return events;
  }

  // What a run that cannot be done says; it must leave nothing behind.
  std::string ErrorOf(FrameRange frames = {}, const std::vector<std::string>& logs = {}) {
    const auto before = folder_.CountEntries();
    try {
      Run(frames, logs);
      return "no error";
    } catch (const ConfigError& e) {
      EXPECT_EQ(folder_.CountEntries(), before);
      return e.what();
    }
  }

  CapturedLog log_;
  TemporaryDirectory folder_;
  std::string in_;
  std::string out_;
  std::string prefix_;
  std::string report_;
  std::stop_source stop_;
  GreyAdapter adapter_;
};

std::vector<TestEvent> FramesWithGrey(const std::vector<int>& greys) {
  std::vector<TestEvent> events = {RigEvent(0)};
  for (size_t i = 0; i < greys.size(); ++i) {
    events.push_back(LeftEvent(static_cast<int64_t>(i), greys[i]));
    events.push_back(TofEvent(static_cast<int64_t>(i)));
  }
  return events;
}

// The answer of GreyAdapter to frame `seq`, completed by `last`.
TestEvent AnswerTo(int64_t seq, int grey, const TestEvent& last) {
  TestEvent event = SeedsEvent(seq, grey);
  event.utime = last.utime;
  return event;
}

TEST_F(ReplayTest, AnswersEveryFrameWithTheTimeOfTheEventThatCompletedIt) {
  WriteLog(in_, {RigEvent(0), LeftEvent(0, 10), TofEvent(0), TofEvent(1), LeftEvent(1, 11)});
  EXPECT_EQ(Run(), 0);
  EXPECT_THAT(Answers(),
              ElementsAre(AnswerTo(0, 10, TofEvent(0)), AnswerTo(1, 11, LeftEvent(1, 11))));
  EXPECT_THAT(report_, HasSubstr("grey: 5 events; frames: 2 in, 2 out (0 degenerate), 0 failed, 0 "
                                 "incomplete, 0 left out; 0 bad messages, 0 damaged bytes"));
}

TEST_F(ReplayTest, GivesAStageWithMemoryTheFramesBefore) {
  WriteLog(in_, FramesWithGrey({1, 2, 3, 4, 5, 6, 7}));
  adapter_.warm_up = 2;
  EXPECT_EQ(Run({.first = 4, .last = 5}), 0);
  EXPECT_THAT(adapter_.seen, ElementsAre(2, 3, 4, 5));
  EXPECT_THAT(Answers(), ElementsAre(AnswerTo(4, 5, TofEvent(4)), AnswerTo(5, 6, TofEvent(5))));
  EXPECT_THAT(report_, HasSubstr("2 in, 2 out"));
  EXPECT_THAT(report_, HasSubstr("0 damaged bytes; 2 frames to warm up; "));
  adapter_.seen.clear();
  EXPECT_EQ(Run({.first = 1, .last = 1}), 0);
  EXPECT_THAT(adapter_.seen, ElementsAre(0, 1));
  EXPECT_THAT(ErrorOf({.first = 9}), HasSubstr("--frames: none of them"));
}

TEST_F(ReplayTest, CountsAFrameToWarmUpThatFails) {
  WriteLog(in_, FramesWithGrey({255, 2}));
  adapter_.warm_up = 1;
  EXPECT_EQ(Run({.first = 1}), 1);
  EXPECT_THAT(report_, HasSubstr("1 in, 1 out (0 degenerate), 1 failed"));
}

TEST_F(ReplayTest, GivesEqualFilesTwice) {
  WriteLog(in_, FramesWithGrey({5, 0, 7}));
  Run();
  const std::vector<TestEvent> first = ReadLog(out_);
  std::filesystem::rename(out_, out_ + ".first");
  Run();
  EXPECT_EQ(ReadLog(out_), first);
  EXPECT_EQ(std::filesystem::file_size(out_), std::filesystem::file_size(out_ + ".first"));
}

TEST_F(ReplayTest, AnswersADegenerateFrameAndGoesOnBehindAFailedOne) {
  WriteLog(in_, FramesWithGrey({0, 255, 7}));
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(Answers(), ElementsAre(AnswerTo(0, 0, TofEvent(0)), AnswerTo(2, 7, TofEvent(2))));
  EXPECT_THAT(report_, HasSubstr("3 in, 2 out (1 degenerate), 1 failed"));
}

TEST_F(ReplayTest, SaysThatAllFramesAreDegenerate) {
  WriteLog(in_, FramesWithGrey({0, 0}));
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(
      log_.Lines(),
      Contains(HasSubstr("all 2 frames are degenerate, the last error is: frame 1: too dark")));
  EXPECT_THAT(Answers(), SizeIs(2));
  WriteLog(in_, FramesWithGrey({0, 0, 3}));
  EXPECT_EQ(Run(), 0) << "one of them says something";
  EXPECT_THAT(log_.Lines(), Not(Contains(HasSubstr("all 3 frames"))));
}

TEST_F(ReplayTest, KnowsTheCalibrationFromTheStart) {
  WriteLog(in_, {LeftEvent(0, 10), TofEvent(0), LeftEvent(1, 11), RigEvent(1), TofEvent(1)});
  EXPECT_EQ(Run(), 0);
  EXPECT_THAT(Answers(), ElementsAre(AnswerTo(0, 10, TofEvent(0)), AnswerTo(1, 11, TofEvent(1))));
}

TEST_F(ReplayTest, WorksOnTheFramesInRangeOnlyAndMissesNoOther) {
  WriteLog(in_, FramesWithGrey({10, 11, 12, 13, 14}));
  EXPECT_EQ(Run({.first = 1, .last = 3}), 0);
  EXPECT_THAT(Answers(), ElementsAre(AnswerTo(1, 11, TofEvent(1)), AnswerTo(2, 12, TofEvent(2)),
                                     AnswerTo(3, 13, TofEvent(3))));
  EXPECT_THAT(report_, HasSubstr("11 events; frames: 3 in, 3 out (0 degenerate), 0 failed, 0 "
                                 "incomplete, 0 left out"));
}

TEST_F(ReplayTest, CountsWhatTheLogLacks) {
  // Frame 1 has no TOF, frames 2 to 4 are not there, frame 5 is unfinished at the end.
  WriteLog(in_, {RigEvent(0), LeftEvent(0, 10), TofEvent(0), LeftEvent(1, 11), LeftEvent(5, 15)});
  EXPECT_EQ(Run(), 0);
  EXPECT_THAT(report_, HasSubstr("1 in, 1 out (0 degenerate), 0 failed, 2 incomplete, 3 left out"));
}

TEST_F(ReplayTest, ReadsAndWritesUnderThePrefix) {
  prefix_ = "A_";
  WriteLog(in_, {RigEvent(0, "A_"), LeftEvent(0, 99), LeftEvent(0, 10, "A_"), TofEvent(0, "A_"),
                 TofEvent(0, "B_A_")});
  EXPECT_EQ(Run(), 0);
  ASSERT_THAT(Answers(), SizeIs(1));
  EXPECT_EQ(Answers()[0].channel, "A_SPROUT_SEEDS");
  EXPECT_EQ(Answers()[0].data, SeedsEvent(0, 10).data);
}

TEST_F(ReplayTest, TakesThePartsFromSeveralLogs) {
  const std::string second = folder_ / "second.lcm";
  WriteLog(in_, {RigEvent(0), LeftEvent(0, 10), LeftEvent(1, 11), TofEvent(1)});
  WriteLog(second, {TofEvent(0), TofEvent(2)});
  EXPECT_EQ(Run({}, {in_, second}), 0);
  EXPECT_THAT(Answers(), ElementsAre(AnswerTo(0, 10, TofEvent(0))))
      << "TOF comes from the second log only";
}

TEST_F(ReplayTest, SaysThatThePartsOfARecordingAreNotJoined) {
  const std::string second = folder_ / "second.lcm";
  WriteLog(in_, FramesWithGrey({10, 11}));
  WriteLog(second, {RigEvent(2), LeftEvent(2, 12), TofEvent(2)});
  EXPECT_EQ(Run({}, {in_, second}), 1);
  EXPECT_THAT(Answers(), SizeIs(1));
  EXPECT_THAT(log_.Lines(), Contains(HasSubstr(in_ + ": 2 messages on SPROUT_LEFT are not used")));
}

TEST_F(ReplayTest, SaysWhichCalibrationIsMissing) {
  FrameId other = TestId(1);
  other.rig_id = "other";
  const auto as_other = [&](TestEvent event, Part part) {
    event.data = EncodePart(other, part, DecodePart(part, event.data)->value);
    return event;
  };
  const std::vector<TestEvent> others = {as_other(LeftEvent(1, 11), Part::kLeft),
                                         as_other(TofEvent(1), Part::kTof)};
  const std::string said =
      "no SPROUT_RIG with the rig_id of frames, 'other'; it has '" + TestId(0).rig_id + "'";
  WriteLog(in_, {RigEvent(0), others[0], others[1], LeftEvent(2, 10), TofEvent(2)});
  EXPECT_EQ(Run(), 0);
  EXPECT_THAT(report_, HasSubstr("1 incomplete"));
  EXPECT_THAT(log_.Lines(), Contains(HasSubstr(said)));
  WriteLog(in_, {RigEvent(0), others[0], others[1]});
  EXPECT_EQ(ErrorOf(), "--replay " + in_ + ": " + said);
}

TEST_F(ReplayTest, SkipsABadMessageAndSaysSoInItsExitCode) {
  TestEvent bad = LeftEvent(1, 11);
  bad.data.pop_back();
  WriteLog(in_, {RigEvent(0), LeftEvent(0, 10), TofEvent(0), bad, TofEvent(1), LeftEvent(2, 12),
                 TofEvent(2)});
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(Answers(), SizeIs(2));
  EXPECT_THAT(report_, HasSubstr("1 incomplete, 0 left out; 1 bad messages"));
}

TEST_F(ReplayTest, IsQuietAboutAClockThatWasAheadOfThisOne) {
  constexpr int64_t kIn2200 = 72'581'184'000;
  WriteLog(in_, {RigEvent(0), LeftEvent(kIn2200, 10), TofEvent(kIn2200)});
  EXPECT_EQ(Run(), 0);
  EXPECT_THAT(log_.Lines(), Not(Contains(HasSubstr("in the future"))));
}

TEST_F(ReplayTest, TakesTheFirstOfTwoMessagesThatDifferAndSaysSo) {
  WriteLog(in_, {RigEvent(0), LeftEvent(0, 10), LeftEvent(0, 10), TofEvent(0), LeftEvent(1, 11),
                 LeftEvent(1, 12), TofEvent(1)});
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(Answers(), ElementsAre(AnswerTo(0, 10, TofEvent(0)), AnswerTo(1, 11, TofEvent(1))));
  EXPECT_THAT(report_, HasSubstr("; 1 bad messages"));
  EXPECT_THAT(log_.Lines(), Contains(HasSubstr("frame 1 has two that differ, the first counts")));
}

TEST_F(ReplayTest, WorksOnWhatIsLeftOfADamagedLogAndSaysSoInItsExitCode) {
  WriteLog(in_, FramesWithGrey({10, 11, 12}));
  std::filesystem::resize_file(in_, std::filesystem::file_size(in_) - 1);
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(Answers(), SizeIs(2));
  EXPECT_THAT(report_, Not(HasSubstr(" 0 damaged bytes")));
}

TEST_F(ReplayTest, KeepsWhatItAnsweredWhenItIsStopped) {
  WriteLog(in_, FramesWithGrey({10, 11, 12}));
  int frames = 0;
  adapter_.on_frame = [&] {
    if (++frames == 2) stop_.request_stop();
  };
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(Answers(), ElementsAre(AnswerTo(0, 10, TofEvent(0)), AnswerTo(1, 11, TofEvent(1))));
  EXPECT_THAT(report_, HasSubstr("stopped after 5 events"));
  EXPECT_EQ(folder_.CountEntries(), 2) << "no other file is left";
}

TEST_F(ReplayTest, NamesTheChannelsThatAreMissingAndThoseThatAreThere) {
  WriteLog(in_, {LeftEvent(0, 10), LeftEvent(1, 11), SeedsEvent(0, 1)});
  EXPECT_EQ(ErrorOf(), "--replay " + in_ +
                           ": no SPROUT_TOF, SPROUT_RIG; it has SPROUT_LEFT (2), SPROUT_SEEDS (1)");
  WriteLog(in_, {});
  EXPECT_THAT(ErrorOf(), HasSubstr("it has no events"));
}

TEST_F(ReplayTest, NamesTheFramesThatAreThereWhenNoneIsInRange) {
  WriteLog(in_, FramesWithGrey({10, 11, 12}));
  EXPECT_THAT(ErrorOf({.first = 3, .last = 9}),
              ::testing::AllOf(HasSubstr("--frames: none of them in "), HasSubstr("it has 0:2")));
}

TEST_F(ReplayTest, SaysSoWhenNoFrameIsComplete) {
  WriteLog(in_, {RigEvent(0), LeftEvent(0, 10), TofEvent(1)});
  EXPECT_THAT(ErrorOf(), HasSubstr("no frame is complete (2 lack a message, 0 bad messages)"));
}

TestEvent InfoEvent(const std::string& stage, const SproutConfig& config,
                    const std::string& prefix = "") {
  return {1, prefix + "SPROUT_PROCESS",
          EncodeProcessInfo({.header = {},
                             .stage = stage,
                             .host = "robot",
                             .version = "0.1.0",
                             .config_digest = "",
                             .config_text = ConfigText(config),
                             .pid = 7})};
}

TEST_F(ReplayTest, BeginsWithVersionAndConfigurationAndNothingOfTheMachine) {
  prefix_ = "A_";
  WriteLog(in_, {LeftEvent(0, 10, "A_"), RigEvent(0, "A_"), TofEvent(0, "A_")});
  Run();
  const TestEvent event = ReadLog(out_).front();
  EXPECT_EQ(event.channel, "A_SPROUT_PROCESS");
  EXPECT_EQ(event.utime, TofEvent(0).utime);  // which completes the first frame
  const Result<ProcessInfo> info = DecodeProcessInfo(event.data);
  ASSERT_TRUE(info) << info.error().text;
  EXPECT_EQ(info->header, (FrameId{.utime = event.utime, .seq = -1, .rig_id = ""}));
  EXPECT_EQ(info->stage, "grey");
  EXPECT_EQ(info->version, Version());
  EXPECT_EQ(info->config_text, ConfigText(LoadConfig({})));
  EXPECT_EQ(info->config_digest, Digest(info->config_text));
  EXPECT_EQ(info->host, "");
  EXPECT_EQ(info->pid, 0);
}

TEST_F(ReplayTest, SaysWhichKeysDifferFromTheRecordedConfiguration) {
  SproutConfig other = LoadConfig({});
  other.mutable_grow()->set_sigma_p_px(2);
  const std::string second = folder_ / "second.lcm";
  WriteLog(in_, {InfoEvent("grey", other), InfoEvent("capture", other), InfoEvent("grey", other),
                 RigEvent(0), LeftEvent(0, 10)});
  WriteLog(second, {TofEvent(0), InfoEvent("prior", other)});
  EXPECT_EQ(Run({}, {in_, second}), 0);
  ASSERT_THAT(log_.Lines(), SizeIs(1));
  EXPECT_THAT(log_.Lines()[0],
              HasSubstr("grey was recorded with another configuration: grow.sigma_p_px = 2, now "));
}

TEST_F(ReplayTest, IsQuietWhenTheConfigurationIsTheRecordedOne) {
  WriteLog(in_, {InfoEvent("grey", LoadConfig({})), RigEvent(0), LeftEvent(0, 10), TofEvent(0)});
  EXPECT_EQ(Run(), 0);
  const std::string again = folder_ / "again.lcm";
  std::filesystem::rename(out_, again);
  EXPECT_EQ(Run({}, {in_, again}), 0);
  EXPECT_THAT(log_.Lines(), ::testing::IsEmpty());
}

TEST_F(ReplayTest, LeavesAnOlderFileAloneWhenItCannotWork) {
  WriteLog(out_, {{1, "OLD", {}}});
  WriteLog(in_, {LeftEvent(0, 10)});
  ErrorOf();
  EXPECT_THAT(ReadLog(out_), ElementsAre(TestEvent{1, "OLD", {}}));
}

TEST_F(ReplayTest, RefusesToWriteOverItsInput) {
  WriteLog(in_, FramesWithGrey({10}));
  const std::vector<TestEvent> before = ReadLog(in_);
  std::filesystem::create_symlink(in_, out_);
  EXPECT_THAT(ErrorOf(), HasSubstr("would overwrite --replay " + in_));
  out_ = in_;
  EXPECT_THAT(ErrorOf(), HasSubstr("would overwrite"));
  EXPECT_EQ(ReadLog(in_), before);
}

TEST_F(ReplayTest, RefusesAtOnceWhereNothingCanBeWritten) {
  WriteLog(in_, FramesWithGrey({10}));
  out_ = "";
  EXPECT_THAT(ErrorOf(), HasSubstr("it names no file"));
  out_ = folder_ / "link.lcm";
  std::filesystem::create_symlink("nowhere", out_);
  EXPECT_THAT(ErrorOf(), HasSubstr("a symbolic link"));
}

TEST_F(ReplayTest, NamesALogThatCannotBeReadOrWritten) {
  EXPECT_THAT(ErrorOf(), HasSubstr("--replay " + in_));
  WriteLog(in_, FramesWithGrey({10}));
  out_ = folder_ / "no/such/folder.lcm";
  EXPECT_THAT(ErrorOf(), HasSubstr("--record " + out_));
}

}  // namespace
}  // namespace sprout
