#include "services/tools/log/process_summary.h"

#include <nlohmann/json.hpp>

#include "tests/services/tools/log/graph_log.h"

namespace sprout::log {
namespace {

using testing::HasSubstr;
using testing::Not;

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
  const MainOutcome text = RunLog({"info", log});
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_THAT(text.out, HasSubstr("sprout.process_info_t"));
  EXPECT_THAT(text.out,
              HasSubstr("\ngrow         0.2.0 (test)           digest of 0.8      robot\n"));
  EXPECT_THAT(text.out, Not(HasSubstr("sigma_p_px")));
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
  const MainOutcome outcome = RunLog({"diff", a, b});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("\ngrow: grow.sigma_p_px = 0.8 in A, 2 in B\n"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("capture:")));
  EXPECT_EQ(RunLog({"diff", a, b, "--channels", "SPROUT_PROCESS"}).exit_code, 1);
  EXPECT_THAT(RunLog({"diff", a, a}).out, Not(HasSubstr("sigma_p_px")));
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
  EXPECT_EQ(summary.processes().size(), ProcessSummary::kMost);
  EXPECT_EQ(summary.NewestOf("refine"), nullptr);
}

}  // namespace
}  // namespace sprout::log
