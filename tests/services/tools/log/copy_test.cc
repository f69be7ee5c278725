#include <gmock/gmock.h>

#include <filesystem>
#include <map>

#include "tests/services/tools/log/graph_log.h"

// cut, merge and repair.
namespace sprout::log {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::pair<std::string, int64_t>> ChannelsAndFrames(const std::vector<Event>& events) {
  std::vector<std::pair<std::string, int64_t>> frames;
  for (const Event& event : events)
    frames.emplace_back(event.channel, DecodeFrameId(event.data)->seq);
  return frames;
}

class LogCut : public TestWithLogs {};

TEST_F(LogCut, KeepsFramesAndTheCalibrationTheyNeed) {
  const auto in = folder_.Write("in", GraphEvents(30));
  // The calibration came with frame 11: before these.
  ASSERT_EQ(RunLog({"cut", in, folder_.File("out"), "--frames", "14:15", "--channels",
                    "SPROUT_LEFT,SPROUT_SEEDS"})
                .exit_code,
            0);
  const LogContent out = ReadLog(folder_.File("out"));
  EXPECT_THAT(out.damage, IsEmpty());
  EXPECT_THAT(ChannelsAndFrames(out.events),
              testing::ElementsAre(std::pair("SPROUT_RIG", 11), std::pair("SPROUT_LEFT", 14),
                                   std::pair("SPROUT_SEEDS", 14), std::pair("SPROUT_LEFT", 15),
                                   std::pair("SPROUT_SEEDS", 15)));
  EXPECT_EQ(out.events[1].data, PartEvent(Part::kLeft, 14).data);
  EXPECT_EQ(out.events[1].utime, PartEvent(Part::kLeft, 14).utime);
  EXPECT_EQ(out.events[1].number, 1);
}

TEST_F(LogCut, KeepsFramesToWarmUpAndTellsWhoNeedsThem) {
  std::vector<Event> events;
  for (int seq = 0; seq < 9; ++seq) {
    events.push_back(PartEvent(Part::kLeft, seq));
    events.push_back(PartEvent(Part::kFused, seq));
  }
  const auto in = folder_.Write("in", events);
  const auto cut = [&](std::vector<std::string> flags) {
    std::vector<std::string> command = {"cut", in, folder_.File("out"), "--force"};
    command.insert(command.end(), flags.begin(), flags.end());
    const MainOutcome outcome = RunLog(command);
    EXPECT_EQ(outcome.exit_code, 0);
    return outcome.err;
  };
  EXPECT_EQ(cut({"--frames", "5:6", "--warm-up", "3", "--channels", "SPROUT_LEFT"}), "");
  EXPECT_THAT(ChannelsAndFrames(ReadLog(folder_.File("out")).events),
              testing::ElementsAre(std::pair("SPROUT_LEFT", 2), std::pair("SPROUT_LEFT", 3),
                                   std::pair("SPROUT_LEFT", 4), std::pair("SPROUT_LEFT", 5),
                                   std::pair("SPROUT_LEFT", 6)));
  EXPECT_EQ(cut({"--frames", "0:6"}), "");
  EXPECT_EQ(cut({"--frames", "2", "--warm-up", "50"}), "");
  EXPECT_THAT(ReadLog(folder_.File("out")).events, testing::SizeIs(6));
  EXPECT_THAT(cut({"--frames", "5:6"}),
              HasSubstr("SPROUT_FUSED depends on earlier frames: a replay of " +
                        folder_.File("out") + " begins anew at frame 5; --warm-up 22 keeps"));
  ExpectRefused({"cut", in, folder_.File("out2"), "--warm-up", "3"}, "--frames");
}

TEST_F(LogCut, FindsACalibrationThatComesLater) {
  const auto in = folder_.Write("in", GraphEvents(30));
  ASSERT_EQ(RunLog({"cut", in, folder_.File("out"), "--frames", ":0", "--channels", "SPROUT_TOF"})
                .exit_code,
            0);
  EXPECT_THAT(ChannelsAndFrames(ReadLog(folder_.File("out")).events),
              testing::ElementsAre(std::pair("SPROUT_TOF", 0), std::pair("SPROUT_RIG", 1)));
}

TEST_F(LogCut, WithoutFlagsCopiesAll) {
  auto events = GraphEvents(12);
  events.push_back({.utime = 1, .channel = "IMU", .data = {1, 2, 3}});
  const auto in = folder_.Write("in", events);
  const std::string out = OutOf({"cut", in, folder_.File("out")});
  EXPECT_EQ(ReadBytes(folder_.File("out")), ReadBytes(in));
  EXPECT_THAT(out, HasSubstr("out: 87 of 87 events\n"));
}

TEST_F(LogCut, KeepsTheGraphOfAPrefix) {
  auto events = GraphEvents(3);
  for (Event event : GraphEvents(3)) {
    event.channel = "TWO_" + event.channel;
    events.push_back(event);
  }
  const auto in = folder_.Write("in", events);
  ASSERT_EQ(RunLog({"cut", in, folder_.File("out"), "--channel-prefix", "TWO_", "--channels",
                    "SPROUT_PRIOR", "--frames", "2"})
                .exit_code,
            0);
  EXPECT_THAT(
      ChannelsAndFrames(ReadLog(folder_.File("out")).events),
      testing::ElementsAre(std::pair("TWO_SPROUT_RIG", 1), std::pair("TWO_SPROUT_PRIOR", 2)));
}

TEST_F(LogCut, NamesAChannelThatTheLogDoesNotHave) {
  const auto in = folder_.Write("in", GraphEvents(3));
  const MainOutcome outcome =
      RunLog({"cut", in, folder_.File("out"), "--channels", "SPROUT_LEFT,SPROUT_RIGTH"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, testing::EndsWith(": no event on SPROUT_RIGTH\n"));
}

TEST_F(LogCut, LeavesNothingBehindWhenItFails) {
  const auto in = folder_.Write("in", GraphEvents(3));
  ExpectRefused({"cut", in, folder_.File("out"), "--frames", "50:60"}, "no event in these frames");
  ExpectRefused({"cut", in, folder_.File("out"), "--channels", "SPROUT_LEFTT"}, "no event");
  ExpectRefused({"cut", in, folder_.File("out"), "--frames", "x"}, "--frames x");
  ExpectRefused({"cut", folder_.File("none"), folder_.File("out")}, "No such file");
  ExpectRefused({"cut", in, folder_.File("none") + "/out"}, "cannot be written");
  EXPECT_EQ(folder_.CountEntries(), 1);
}

TEST_F(LogCut, OverwritesOnlyWhenForced) {
  const auto in = folder_.Write("in", GraphEvents(3));
  const Bytes before = ReadBytes(in);
  ExpectRefused({"cut", in, in, "--frames", "1"}, "exists already");
  EXPECT_EQ(ReadBytes(in), before);
  ExpectRefused({"cut", in, in, "--frames", "77", "--force"}, "no event");
  EXPECT_EQ(ReadBytes(in), before);
  EXPECT_EQ(RunLog({"cut", in, in, "--frames", "1", "--force"}).exit_code, 0);
  EXPECT_EQ(ReadLog(in).events.size(), 8U);
  EXPECT_EQ(folder_.CountEntries(), 1);
}

TEST(LogMerge, OrdersByTimeAndKeepsTheOrderOfEachLog) {
  const LogFolder folder;
  const auto events = GraphEvents(12);
  std::vector<Event> raw;
  std::vector<Event> rest;
  for (const Event& event : events) {
    (event.channel == "SPROUT_LEFT" || event.channel == kStatusChannel ? raw : rest)
        .push_back(event);
  }
  const auto a = folder.Write("a", raw);
  const auto b = folder.Write("b", rest);
  ASSERT_EQ(RunLog({"merge", a, b, "--out", folder.File("out")}).exit_code, 0);
  auto sorted = events;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Event& x, const Event& y) { return x.utime < y.utime; });
  // Not sorted within b: a frame's calibration is recorded last.
  EXPECT_EQ(ReadLog(folder.File("out")).events.size(), events.size());
  EXPECT_EQ(RunLog({"diff", folder.Write("all", events), folder.File("out")}).exit_code, 0);
  const auto merged = ReadLog(folder.File("out")).events;
  EXPECT_EQ(merged[0].channel, kStatusChannel);
  EXPECT_EQ(merged[1].channel, "SPROUT_LEFT");
  EXPECT_EQ(merged.back().number, static_cast<int64_t>(events.size()) - 1);
}

// A recording with all channels, and the replay of one's own prior.
TEST(LogMerge, TakesNewAnswersInThePlaceOfOldOnesOnlyWhenTold) {
  const LogFolder folder;
  const auto events = GraphEvents(4);
  std::vector<Event> replayed;
  for (int seq = 0; seq < 4; ++seq) {
    replayed.push_back(PartEvent(Part::kPrior, seq, LogPrior(seq + 7)));
  }
  replayed.push_back(StatusEvent(3));
  const auto recorded = folder.Write("recorded", events);
  const auto replay = folder.Write("replay", replayed);
  const auto out = folder.File("out");
  ExpectRefused({"merge", recorded, replay, "--out", out},
                "SPROUT_PRIOR of frame 0 is another than in " + recorded + "; --replace takes");
  EXPECT_FALSE(std::filesystem::exists(out));
  EXPECT_THAT(RunLog({"merge", replay, recorded, "--out", out, "--replace"}).err,
              HasSubstr(replay + ": no frame of it is used: later logs have its channels;"));
  const MainOutcome merged =
      RunLog({"merge", recorded, replay, "--out", out, "--replace", "--force"});
  ASSERT_EQ(merged.exit_code, 0);
  EXPECT_EQ(merged.err, "");
  int statuses = 0;
  int priors = 0;
  for (const Event& event : ReadLog(out).events) {
    statuses += event.channel == kStatusChannel ? 1 : 0;
    if (event.channel != "SPROUT_PRIOR") continue;
    EXPECT_EQ(event.data, replayed[static_cast<size_t>(priors++)].data);
  }
  EXPECT_EQ(priors, 4);
  EXPECT_EQ(statuses, 5);
  EXPECT_EQ(ReadLog(out).events.size(), events.size() + 1);
}

TEST(LogMerge, OfTwoRecordersHasEachMessageOfAFrameOnce) {
  const LogFolder folder;
  const auto events = GraphEvents(4);
  auto later = events;
  for (Event& event : later) event.utime += 500;
  const auto out = folder.File("out");
  const auto result =
      RunLog({"merge", folder.Write("a", events), folder.Write("b", later), "--out", out});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, testing::HasSubstr("are there once"));
  std::map<std::string, int> counts;
  for (const Event& event : ReadLog(out).events) ++counts[event.channel];
  EXPECT_EQ(counts["SPROUT_LEFT"], 4);
  EXPECT_EQ(counts["SPROUT_PRIOR"], 4);
  EXPECT_EQ(counts["SPROUT_STATUS"], 8) << "of no frame";
}

TEST(LogMerge, RefusesPartsThatAStepOfTheClockWouldShuffle) {
  const LogFolder folder;
  const auto a = folder.Write("a", {PartEvent(Part::kLeft, 0), PartEvent(Part::kLeft, 1)});
  const auto merge = [&](int64_t set_back_us) {
    std::vector<Event> later = {PartEvent(Part::kLeft, 2), PartEvent(Part::kLeft, 3)};
    for (Event& event : later) event.utime -= set_back_us;
    return RunLog({"merge", folder.Write("b", later), a, "--out", folder.File("out"), "--force"});
  };
  const int64_t interval_us = PartEvent(Part::kLeft, 1).utime - PartEvent(Part::kLeft, 0).utime;
  EXPECT_EQ(merge(0).exit_code, 0);
  EXPECT_THAT(merge(2 * interval_us).err,
              HasSubstr(folder.File("b") +
                        ": SPROUT_LEFT has frames from 2 on, and by time they lie among frames 0 "
                        "to 1 of " +
                        a + ": the clock was set back; `cat` joins"));
}

TEST(LogMerge, RefusesOneLogTwice) {
  const LogFolder folder;
  const auto a = folder.Write("a", GraphEvents(2));
  const auto b = folder.Write("b", {});
  ExpectRefused({"merge", a, b, a, "--out", folder.File("out")},
                a + " and " + a + " are one log; allowed: each once");
  const auto link = folder.File("link");
  std::filesystem::create_symlink(a, link);
  ExpectRefused({"merge", a, link, "--out", folder.File("out"), "--replace"}, "are one log");
}

TEST(LogMerge, OfEqualTimesTakesTheLogNamedFirst) {
  const LogFolder folder;
  const auto a = folder.Write(
      "a", {{.utime = 5, .channel = "A1", .data = {}}, {.utime = 7, .channel = "A2", .data = {}}});
  const auto b = folder.Write(
      "b", {{.utime = 5, .channel = "B1", .data = {}}, {.utime = 6, .channel = "B2", .data = {}}});
  const auto empty = folder.Write("empty", {});
  ASSERT_EQ(RunLog({"merge", b, a, empty, "--out", folder.File("out")}).exit_code, 0);
  std::vector<std::string> channels;
  for (const Event& event : ReadLog(folder.File("out")).events) channels.push_back(event.channel);
  EXPECT_THAT(channels, testing::ElementsAre("B1", "A1", "B2", "A2"));
}

TEST(LogRepair, WritesAllGoodEventsAndSaysWhatWasLost) {
  const LogFolder folder;
  auto events = GraphEvents(12);
  Bytes bytes = MakeLog(events);
  bytes[static_cast<size_t>(events[20].offset) + 25] ^= 0x40;  // length
  bytes.resize(static_cast<size_t>(events.back().offset) + 100);
  WriteBytes(folder.File("in"), bytes);
  const std::string outcome = OutOf({"repair", folder.File("in"), folder.File("out")});
  EXPECT_THAT(outcome, HasSubstr("1 event lost\n"));
  EXPECT_THAT(outcome, HasSubstr("(100): torn tail"));
  EXPECT_THAT(outcome, HasSubstr(" lost in 2 places, 0 undecodable kept\n"));
  events.pop_back();
  events.erase(events.begin() + 20);
  const LogContent out = ReadLog(folder.File("out"));
  EXPECT_EQ(Contents(out.events), Contents(events));
  EXPECT_THAT(out.damage, IsEmpty());
}

TEST(LogRepair, KeepsUndecodableMessages) {
  const LogFolder folder;
  auto events = GraphEvents(3);
  EventOf(events, Part::kLeft, 1).data.pop_back();
  const auto in = folder.Write("in", events);
  const MainOutcome outcome = RunLog({"repair", in, folder.File("out")});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("kept, but undecodable: SPROUT_LEFT, event "));
  EXPECT_EQ(ReadBytes(folder.File("out")), ReadBytes(in));
}

}  // namespace
}  // namespace sprout::log
