#include <gmock/gmock.h>

#include <cstdlib>
#include <ctime>
#include <nlohmann/json.hpp>

#include "common/config/config.h"
#include "common/messages/codec.h"
#include "services/tools/log/channel_summary.h"
#include "tests/services/tools/log/graph_log.h"

namespace sprout::log {
namespace {

using testing::HasSubstr;
using testing::Not;

nlohmann::json Info(const std::string& file, const std::vector<std::string>& flags = {}) {
  std::vector<std::string> arguments = {"info", file, "--json"};
  arguments.insert(arguments.end(), flags.begin(), flags.end());
  const std::string out = OutOf(arguments);
  return nlohmann::json::parse(out);
}

nlohmann::json Channel(const nlohmann::json& info, const std::string& name) {
  for (const auto& channel : info["channels"]) {
    if (channel["name"] == name) return channel;
  }
  return {};
}

class LogInfo : public TestWithLogs {};

TEST_F(LogInfo, DescribesEveryChannel) {
  const auto file = folder_.Write("log", GraphEvents(12));
  const nlohmann::json info = Info(file);
  EXPECT_EQ(info["events"], 7 * 12 + 2);
  EXPECT_EQ(info["whole"], true);
  EXPECT_EQ(info["channels"].size(), 8U);
  const nlohmann::json left = Channel(info, "SPROUT_LEFT");
  EXPECT_EQ(left["type"], "sprout.image_t");
  EXPECT_EQ(left["messages"], 12);
  EXPECT_EQ(left["bytes"], 12 * PartEvent(Part::kLeft, 0).data.size());
  EXPECT_DOUBLE_EQ(left["rate_hz"], 10);
  EXPECT_EQ(left["first_utime"], PartEvent(Part::kLeft, 0).utime);
  EXPECT_EQ(left["last_utime"], PartEvent(Part::kLeft, 11).utime);
  EXPECT_EQ(left["frames"]["first"], 0);
  EXPECT_EQ(left["frames"]["last"], 11);
  EXPECT_EQ(left["undecodable"], 0);
  EXPECT_EQ(Channel(info, "SPROUT_STATUS")["type"], "sprout.stage_status_t");
  EXPECT_FALSE(Channel(info, "SPROUT_RIG").contains("frames"));
}

// fmt 9 formats a time of the system's clock in local time.
TEST_F(LogInfo, TellsTimesInUtcWhateverTheZone) {
  Event event = PartEvent(Part::kLeft, 0);
  event.utime = 1'795'426'900'840'303;
  const auto file = folder_.Write("log", {event});
  for (const char* zone : {"UTC0", "JST-9"}) {
    setenv("TZ", zone, /*replace=*/1);
    tzset();
    EXPECT_THAT(OutOf({"info", file}), HasSubstr("first 2026-11-23 09:41:40.840303 UTC")) << zone;
  }
  unsetenv("TZ");
  tzset();
}

TEST_F(LogInfo, CountsGapsAndRepeatedFrames) {
  auto events = GraphEvents(9);
  Erase(events, Part::kLeft, 3);
  Erase(events, Part::kLeft, 4);
  Erase(events, Part::kLeft, 7);
  events.push_back(PartEvent(Part::kTof, 8));
  const auto file = folder_.Write("log", events);
  const nlohmann::json info = Info(file);
  EXPECT_EQ(info["whole"], false);
  EXPECT_EQ(Channel(info, "SPROUT_LEFT")["frames"]["missing"], 3);
  EXPECT_EQ(Channel(info, "SPROUT_TOF")["frames"]["repeated"], 1);
  const MainOutcome outcome = RunLog({"info", file, "--check"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out, HasSubstr("SPROUT_LEFT: frames left out: 3-4, 7\n"));
  EXPECT_THAT(outcome.out, HasSubstr("no damage\n"));
  EXPECT_EQ(outcome.err, "");
}

TEST_F(LogInfo, MissesNoFrameThatDepthWasToldToLeaveOut) {
  std::vector<Event> events;
  for (const int64_t seq : {0, 3, 6, 9}) events.push_back(PartEvent(Part::kDepth, seq));
  const auto missing = [&] {
    return Channel(Info(folder_.Write("log", events)), "SPROUT_DEPTH")["frames"]["missing"];
  };
  EXPECT_EQ(missing(), 6);
  ProcessInfo depth;
  depth.stage = "depth";
  depth.config_text = ConfigText(LoadConfig({"depth { every: 3 }"}));
  events.push_back({.utime = 1, .channel = "SPROUT_PROCESS", .data = EncodeProcessInfo(depth)});
  EXPECT_EQ(missing(), 0);
  events.erase(events.begin() + 1);
  EXPECT_EQ(missing(), 1);
  EXPECT_THAT(RunLog({"info", folder_.Write("log", events)}).out,
              HasSubstr("SPROUT_DEPTH: frames left out: 1 in all\n"));
}

// Capture was started again after the clock had been set back by an hour.
TEST_F(LogInfo, CountsFramesBehindAClockThatWasSetBack) {
  auto events = GraphEvents(5);
  EXPECT_THAT(RunLog({"info", folder_.Write("log", events)}).out, Not(HasSubstr("clock")));
  for (const int64_t seq : {0, 1, 3}) {
    Event event = PartEvent(Part::kLeft, seq);
    FrameId id = LogFrameId(seq);
    id.utime -= 3'600'000'000;
    event.utime -= 3'600'000'000;
    event.data = EncodePart(id, Part::kLeft, LogValue(Part::kLeft, seq));
    events.push_back(event);
  }
  const std::string out = OutOf({"info", folder_.Write("log", events), "--check"}, 1);
  EXPECT_THAT(out, HasSubstr("the clock was set back, times: 1, by 3600."));
  EXPECT_THAT(out, HasSubstr("SPROUT_LEFT: frame numbers began anew, times: 1\n"));
  EXPECT_THAT(out, HasSubstr("SPROUT_LEFT: frames left out: 2\n"));
}

TEST_F(LogInfo, HasAllFramesWhateverTheirOrder) {
  std::vector<Event> events;
  for (const int64_t seq : {4, 3, 2, 1, 0}) events.push_back(PartEvent(Part::kLeft, seq));
  const auto log = folder_.Write("log", events);
  const std::string out = OutOf({"info", log});
  EXPECT_THAT(out, HasSubstr(" 0-4 "));
  EXPECT_THAT(out, HasSubstr("SPROUT_LEFT: frames that stand behind later ones: 4\n"));
}

TEST_F(LogInfo, NamesTheCalibrationsOfTwoRigs) {
  std::vector<Event> events = GraphEvents(2);
  EXPECT_THAT(OutOf({"info", folder_.Write("log", events)}), Not(HasSubstr("calibrations")));
  FrameId id = LogFrameId(2);
  id.rig_id = "beef";
  events.push_back(PartEvent(Part::kLeft, 2));
  events.back().data = EncodePart(id, Part::kLeft, LogValue(Part::kLeft, 2));
  EXPECT_THAT(OutOf({"info", folder_.Write("log", events)}),
              HasSubstr("\nframes of several calibrations, rig_id: beef, cafe\n"));
}

TEST_F(LogInfo, CountsFramesWhoseTimeDoesNotRise) {
  std::vector<Event> events = {PartEvent(Part::kLeft, 0), PartEvent(Part::kLeft, 1)};
  FrameId id = LogFrameId(2);
  id.utime = LogFrameId(1).utime;
  events.push_back(events.back());
  events.back().data = EncodePart(id, Part::kLeft, LogValue(Part::kLeft, 2));
  EXPECT_THAT(OutOf({"info", folder_.Write("log", events)}),
              HasSubstr("SPROUT_LEFT: frames whose utime does not rise: 1\n"));
}

TEST_F(LogInfo, TellsWhenTheClockWasSetForward) {
  auto events = GraphEvents(5);
  events.back().utime += 7'200'000'000;
  EXPECT_THAT(RunLog({"info", folder_.Write("log", events)}).out,
              HasSubstr("\nno message for 7200.000 s: a pause, or the clock was set forward"));
}

TEST_F(LogInfo, FindsMessagesThatCannotBeDecoded) {
  auto events = GraphEvents(4);
  EventOf(events, Part::kLeft, 2).data.pop_back();
  EventOf(events, Part::kTof, 1).data = PartEvent(Part::kSeeds, 1).data;
  EventOf(events, Part::kRight, 3).data = {1, 2, 3};
  const auto file = folder_.Write("log", events);
  const nlohmann::json info = Info(file);
  for (const char* name : {"SPROUT_LEFT", "SPROUT_TOF", "SPROUT_RIGHT"}) {
    EXPECT_EQ(Channel(info, name)["undecodable"], 1) << name;
  }
  const std::string out = OutOf({"info", file, "--check"}, 1);
  EXPECT_THAT(out, HasSubstr("SPROUT_LEFT: first undecodable message: event "));
  EXPECT_THAT(out, HasSubstr("sprout.seeds_t is not that of sprout.tof_image_t"));
  EXPECT_THAT(out, HasSubstr(": 3 bytes, too few for a sprout.image_t"));
}

TEST_F(LogInfo, ReportsDamage) {
  auto events = GraphEvents(4);
  Bytes bytes = MakeLog(events);
  bytes[static_cast<size_t>(events[5].offset)] ^= 1;
  bytes.resize(bytes.size() - 3);
  WriteBytes(folder_.File("log"), bytes);
  const nlohmann::json info = Info(folder_.File("log"));
  ASSERT_EQ(info["damage"].size(), 2U);
  EXPECT_EQ(info["damage"][0]["offset"], events[5].offset);
  EXPECT_EQ(info["damage"][0]["bytes"], events[6].offset - events[5].offset);
  EXPECT_EQ(info["damage"][0]["events"], 1);
  EXPECT_EQ(info["damage"][1]["tail"], true);
  const std::string out = OutOf({"info", folder_.File("log")});
  EXPECT_THAT(out, HasSubstr("1 event lost\n"));
  EXPECT_THAT(out, HasSubstr("torn tail"));
  EXPECT_THAT(out, Not(HasSubstr("no damage")));
}

TEST_F(LogInfo, ShowsForeignTypesByFingerprint) {
  auto events = GraphEvents(2);
  events.push_back({.utime = 1, .channel = "IMU", .data = {0, 1, 2, 3, 4, 5, 6, 7, 8}});
  events.push_back({.utime = 1, .channel = "PING", .data = {}});
  const nlohmann::json info = Info(folder_.Write("log", events));
  EXPECT_EQ(info["whole"], true);
  EXPECT_EQ(Channel(info, "IMU")["type"], "0x0001020304050607");
  EXPECT_EQ(Channel(info, "IMU")["undecodable"], 0);
  EXPECT_EQ(Channel(info, "PING")["type"], "no type");
}

TEST_F(LogInfo, LooksAtOneGraphOnly) {
  auto events = GraphEvents(2);
  Event other = PartEvent(Part::kLeft, 1);
  other.channel = "TWO_SPROUT_LEFT";
  events.push_back(other);
  const auto file = folder_.Write("log", events);
  const nlohmann::json info = Info(file, {"--channel-prefix", "TWO_"});
  ASSERT_EQ(info["channels"].size(), 1U);
  EXPECT_EQ(info["channels"][0]["name"], "TWO_SPROUT_LEFT");
  EXPECT_EQ(info["channels"][0]["type"], "sprout.image_t");
}

TEST_F(LogInfo, SaysSoWhenThePrefixIsThatOfNoChannel) {
  const auto file = folder_.Write("log", GraphEvents(2));
  const std::string out = OutOf({"info", file, "--check", "--channel-prefix", "WRONG_"}, 1);
  EXPECT_THAT(out, HasSubstr("no channel begins with this --channel-prefix; there are "
                             "channels as SPROUT_"));
  EXPECT_EQ(Info(file, {"--channel-prefix", "WRONG_"})["whole"], false);
}

TEST_F(LogInfo, DescribesAnEmptyLog) {
  const MainOutcome outcome = RunLog({"info", folder_.Write("log", {}), "--check"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out, HasSubstr("0.00 MB, 0 events\nthe file is empty: nothing was written"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("no damage")));
}

FrameId Id(int64_t seq, int64_t start = 0) {
  return {.utime = start + 100 * seq, .seq = seq, .rig_id = ""};
}

TEST(Sequence, ShowsTheFirstGapsOnly) {
  Sequence sequence;
  for (int seq = 0; seq < 100; seq += 2) sequence.Add(Id(seq));
  EXPECT_EQ(sequence.missing(), 49);
  EXPECT_EQ(sequence.GapText(), "1, 3, 5, 7, 9, 11, 13, 15, 17, 19, ...");
}

TEST(Sequence, SurvivesNumbersThatAreDamaged) {
  Sequence sequence;
  for (int i = 0; i < 3; ++i) {
    sequence.Add(Id(0, 1000 * i));
    sequence.Add({.utime = 1000 * i + 500, .seq = INT64_MAX, .rig_id = ""});
  }
  EXPECT_EQ(sequence.missing(), INT64_MAX);
}

Event ProcessEvent(int64_t seq, const std::string& stage, const std::string& config) {
  const ProcessInfo info{.header = {},
                         .stage = stage,
                         .host = "robot",
                         .version = "0.2.0 (test)",
                         .config_digest = "digest of " + config,
                         .config_text = "grow {\n  sigma_p_px: " + config + "\n}\n",
                         .pid = 7};
  Event event;
  event.utime = LogFrameId(seq).utime;
  event.channel = kProcessChannel;
  event.data = EncodeProcessInfo(info);
  return event;
}

// A log in which two stages say what they are before each frame.
std::vector<Event> EventsWithProcesses(const std::string& config) {
  std::vector<Event> events;
  for (const Event& event : GraphEvents(4)) {
    if (event.channel == kStatusChannel) {
      const int64_t seq = (event.utime - LogFrameId(0).utime) / 100'000;
      events.push_back(ProcessEvent(seq, "capture", "1"));
      events.push_back(ProcessEvent(seq, "grow", config));
    }
    events.push_back(event);
  }
  return events;
}

TEST(ProcessesOfALog, AreShownByInfoEachOnce) {
  const LogFolder folder;
  const std::string log = folder.Write("run.lcm", EventsWithProcesses("0.8"));
  const std::string text = OutOf({"info", log});
  EXPECT_THAT(text, HasSubstr("sprout.process_info_t"));
  EXPECT_THAT(text, HasSubstr("\ngrow         0.2.0 (test)           digest of 0.8      robot\n"));
  EXPECT_THAT(text, Not(HasSubstr("sigma_p_px")));
  EXPECT_THAT(RunLog({"info", log, "--config"}).out, HasSubstr("  sigma_p_px: 0.8\n"));
  const auto json = nlohmann::json::parse(RunLog({"info", log, "--json"}).out);
  ASSERT_EQ(json["processes"].size(), 2U);
  EXPECT_EQ(json["processes"][1]["stage"], "grow");
  EXPECT_THAT(json["processes"][1]["config_text"], HasSubstr("sigma_p_px: 0.8"));
  EXPECT_EQ(json["whole"], true);
}

TEST(ProcessesOfALog, AreNoDifferenceOfTheAnswersButShown) {
  const LogFolder folder;
  const std::string a = folder.Write("a.lcm", EventsWithProcesses("0.8"));
  const std::string b = folder.Write("b.lcm", EventsWithProcesses("2"));
  const std::string outcome = OutOf({"diff", a, b});
  EXPECT_THAT(outcome, HasSubstr("\ngrow: grow.sigma_p_px = 0.8 in A, 2 in B\n"));
  EXPECT_THAT(outcome, Not(HasSubstr("capture:")));
  EXPECT_EQ(RunLog({"diff", a, b, "--channels", "SPROUT_PROCESS"}).exit_code, 1);
  EXPECT_THAT(RunLog({"diff", a, a}).out, Not(HasSubstr("sigma_p_px")));
}

// The texts of messages are chosen by their sender, which may be anybody who reaches the port.
TEST(TextsOfALog, CannotMoveTheCursorOfATerminal) {
  const LogFolder folder;
  std::vector<Event> events = GraphEvents(1);
  const std::string before = folder.Write("a", events);
  events.push_back(ProcessEvent(0, "grow\x1b[2J\nno damage", "\x1b[2J"));
  FrameId id = LogFrameId(0);
  id.rig_id = "\x1b[2J";
  EventOf(events, Part::kTof, 0).data = EncodePart(id, Part::kTof, LogValue(Part::kTof, 0));
  const std::string log = folder.Write("\x1b[2J", events);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"info", "--config", log}, {"diff", before, log}}) {
    const std::string out = RunLog(words).out;
    EXPECT_THAT(out, HasSubstr("\\x1b[2J"));
    EXPECT_THAT(out, Not(HasSubstr("\x1b")));
  }
  EXPECT_THAT(RunLog({"info", log}).out, HasSubstr("\\x0ano damage"));
}

TEST(ProcessesOfALog, StayWithFramesThatAreCutOut) {
  const LogFolder folder;
  const std::string log = folder.Write("run.lcm", EventsWithProcesses("0.8"));
  const std::string cut = folder.File("cut.lcm");
  EXPECT_EQ(RunLog({"cut", log, cut, "--frames", "2:3"}).exit_code, 0);
  const auto json = nlohmann::json::parse(RunLog({"info", cut, "--json"}).out);
  EXPECT_EQ(json["processes"].size(), 2U);
  for (const auto& channel : json["channels"]) {
    if (channel["name"] != "SPROUT_PROCESS") continue;
    EXPECT_EQ(channel["messages"], 2);
  }
  EXPECT_EQ(RunLog({"cut", log, cut, "--channels", "SPROUT_LEFT", "--force"}).exit_code, 0);
  EXPECT_THAT(RunLog({"info", cut}).out, Not(HasSubstr("SPROUT_PROCESS")));
}

TEST(ProcessesOfALog, DoNotGrowWithoutEnd) {
  ProcessSummary summary;
  for (int i = 0; i < 1000; ++i) summary.Add(ProcessEvent(0, "grow", std::to_string(i)).data);
  summary.Add(std::vector<uint8_t>(40));
  EXPECT_EQ(summary.processes().size(), ProcessSummary::kMaxProcesses);
  EXPECT_EQ(summary.NewestOf("refine"), nullptr);
}

}  // namespace

}  // namespace sprout::log
