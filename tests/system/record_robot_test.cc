#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <opencv2/core.hpp>
#include <optional>
#include <thread>

#include "common/app/stage_monitor.h"
#include "common/messages/codec.h"
#include "tests/common/testing/test_with_folder.h"
#include "tests/system/graph.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::vector<std::string> kCamera = {"--source", "synthetic:160x120", "--rate", "20"};

std::vector<fs::path> Logs(const fs::path& folder) {
  std::vector<fs::path> logs;
  std::error_code missing;
  for (const auto& entry : fs::directory_iterator(folder, missing)) logs.push_back(entry.path());
  std::ranges::sort(logs);
  return logs;
}

int64_t BytesOfAll(const std::vector<fs::path>& logs) {
  int64_t bytes = 0;
  for (const fs::path& log : logs) bytes += static_cast<int64_t>(fs::file_size(log));
  return bytes;
}

std::vector<int64_t> SeqsOf(const ChannelBytes& channels, Part part,
                            const std::string& prefix = "") {
  std::vector<int64_t> seqs;
  const auto found = channels.find(prefix + std::string(RowOf(part).channel));
  if (found == channels.end()) return seqs;
  for (const auto& bytes : found->second) seqs.push_back(DecodeFrameId(bytes)->seq);
  return seqs;
}

bool AreConsecutive(const std::vector<int64_t>& seqs) {
  return std::ranges::adjacent_find(seqs, [](int64_t a, int64_t b) { return b != a + 1; }) ==
         seqs.end();
}

/// Times of the first and the last event, s, and the newest status of the recorder.
struct LogSummary {
  double first_s = 0;
  double last_s = 0;
  StageStatus status;
  bool ends_with_it = false;
};

LogSummary Summarise(const fs::path& log) {
  LogSummary summary;
  LogReader reader(log);
  LogEvent event;
  while (reader.Next(event)) {
    summary.last_s = static_cast<double>(event.utime) / 1e6;
    if (summary.first_s == 0) summary.first_s = summary.last_s;
    const auto status = DecodeStatus(event.data);
    summary.ends_with_it = status && status->stage == "record";
    if (summary.ends_with_it) summary.status = *status;
  }
  EXPECT_TRUE(reader.damage().empty()) << log;
  return summary;
}

/// Jumps of the clock that a log's events came by, s.
std::vector<double> ClockSteps(const fs::path& log) {
  std::vector<double> steps_s;
  LogReader reader(log);
  LogEvent event;
  std::optional<int64_t> before;
  while (reader.Next(event)) {
    const double step_s = static_cast<double>(event.utime - before.value_or(event.utime)) / 1e6;
    if (std::abs(step_s) > 60) steps_s.push_back(step_s);
    before = event.utime;
  }
  return steps_s;
}

bool HasRecorded(Graph& graph, int64_t frames) {
  return graph.WaitUntil([&](Graph& g) { return g.statuses["record"].frames_out >= frames; });
}

void SleepSeconds(int seconds) { std::this_thread::sleep_for(std::chrono::seconds(seconds)); }

class RecordRobot : public TestWithFolder {};

TEST_F(RecordRobot, KeepsTheSecondsBeforeASignal) {
  const fs::path logs = folder_ / "logs";
  Graph graph;
  Process& record = graph.Start("record", {"--dir", logs, "--ring", "2", "--after", "1"});
  graph.Start("capture", kCamera);
  ASSERT_TRUE(HasRecorded(graph, 80));
  EXPECT_TRUE(Logs(logs).empty());
  const double signal_s = static_cast<double>(NowUtime()) / 1e6;
  record.Signal(SIGUSR1);
  SleepSeconds(3);
  record.Signal(SIGINT);
  ASSERT_EQ(record.Wait(), 0) << record.Output();
  ASSERT_EQ(Logs(logs).size(), 1U) << record.Output();
  const fs::path log = Logs(logs)[0];
  const LogSummary summary = Summarise(log);
  EXPECT_NEAR(summary.first_s, signal_s - 2, 0.5);
  // Its own last status comes when the log is closed: here by the signal, as a trigger could still
  // have continued it.
  EXPECT_NEAR(summary.last_s, signal_s + 3, 0.7);
  EXPECT_TRUE(summary.ends_with_it);
  EXPECT_THAT(summary.status.last_error, HasSubstr("trigger (SIGUSR1)"));
  const ChannelBytes channels = ReadChannels(log);
  const std::vector<int64_t> seqs = SeqsOf(channels, Part::kLeft);
  EXPECT_GE(seqs.size(), 40U);
  EXPECT_TRUE(AreConsecutive(seqs));
}

TEST_F(RecordRobot, NamesChannelsOnWhichNothingCame) {
  Graph graph;
  Process& record = graph.Start(
      "record", {"--dir", folder_ / "logs", "--channels", "SPROUT_LEFT,SPROUT_RIGTH", "--channels",
                 "SPROUT_RIGTH", "--ring", "5", "--trigger-channel", "BUMPR"});
  graph.PublishPart({.utime = NowUtime(), .seq = 1, .rig_id = "a"}, Part::kLeft,
                    cv::Mat(cv::Mat1b(9, 9)));
  ASSERT_TRUE(HasRecorded(graph, 1));
  record.Signal(SIGTERM);
  ASSERT_EQ(record.Wait(), 0) << record.Output();
  EXPECT_THAT(record.Output(), HasSubstr("; nothing came on --trigger-channel BUMPR; "
                                         "nothing came on SPROUT_RIGTH\n"));
}

TEST_F(RecordRobot, SaysWhileItRecordsOnWhichChannelsNothingComes) {
  Graph graph;
  graph.Start("capture", kCamera);
  graph.Start("record", {"--dir", folder_ / "logs", "--channels", "SPROUT_LEFT,SPROUT_RIGTH"});
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    const std::string& said = g.statuses["record"].last_error;
    return said.starts_with("nothing heard on SPROUT_RIGTH; heard in a second: ") &&
           said.find("SPROUT_RIGHT (") != std::string::npos;
  }));
}

TEST_F(RecordRobot, SaysSoWhenNothingCameIntoTheRing) {
  EXPECT_THAT(OutputOf({"sprout-record", "--dir", folder_ / "logs", "--ring", "5",
                        "--channel-prefix", "NOBODY_", "--seconds", "1"},
                       1),
              HasSubstr("nothing came; is the graph running"));
}

TEST_F(RecordRobot, KeepsWhatAMessageOrALowConfidenceAsksFor) {
  const fs::path logs = folder_ / "logs";
  Graph graph("A_");
  Process& record =
      graph.Start("record", {"--dir", logs, "--channels", "SPROUT_LEFT", "--ring", "5", "--after",
                             "0", "--trigger-channel", "BUMPER", "--trigger-confidence", "0.5"});
  const FrameId id{.utime = NowUtime(), .seq = 1, .rig_id = "a"};
  graph.PublishPart(id, Part::kLeft, cv::Mat(cv::Mat1b(9, 9)));
  graph.PublishPart(id, Part::kConfidence, cv::Mat(cv::Mat1b(9, 9, 200)));
  ASSERT_TRUE(HasRecorded(graph, 1));
  SleepSeconds(1);
  EXPECT_TRUE(Logs(logs).empty());
  graph.Publish("BUMPER", std::vector<uint8_t>{1});
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["record"].last_error.starts_with("trigger (a message on BUMPER)");
  }));
  graph.PublishPart(id, Part::kConfidence, cv::Mat(cv::Mat1b(9, 9, 100)));
  ASSERT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["record"].last_error.starts_with("trigger (frame 1: mean confidence 0.392)");
  }));
  record.Signal(SIGTERM);
  ASSERT_EQ(record.Wait(), 0) << record.Output();
  ASSERT_EQ(Logs(logs).size(), 1U) << record.Output();  // the ring of the second reaches into it
  const ChannelBytes channels = ReadChannels(Logs(logs)[0]);
  EXPECT_EQ(SeqsOf(channels, Part::kLeft, "A_").size(), 1U);
  EXPECT_EQ(channels.size(), 2U);  // and our own status
  EXPECT_TRUE(channels.contains("A_SPROUT_STATUS"));
}

TEST_F(RecordRobot, SaysThatNoConfidenceComesThatCouldTrigger) {
  Graph graph;
  graph.Start("record", {"--dir", folder_ / "logs", "--ring", "5", "--trigger-confidence", "0.5"});
  const auto publish = [&](int64_t seq, Part part) {
    graph.PublishPart({.utime = NowUtime(), .seq = seq, .rig_id = "a"}, part,
                      cv::Mat(cv::Mat1b(9, 9, 200)));
  };
  for (int64_t seq = 0; seq < 30; ++seq) publish(seq, Part::kLeft);
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["record"].last_error.starts_with("--trigger-confidence cannot trigger");
  }));
  publish(29, Part::kConfidence);
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) { return g.statuses["record"].last_error.empty(); }));
}

TEST_F(RecordRobot, GoesOnInTheNextLogWithoutAGap) {
  const fs::path logs = folder_ / "logs";
  Graph graph("A_");
  Process& record = graph.Start("record", {"--dir", logs, "--max-mb", "1"});
  graph.Start("capture", kCamera);
  ASSERT_TRUE(HasRecorded(graph, 80));
  record.Signal(SIGTERM);
  ASSERT_EQ(record.Wait(), 0) << record.Output();
  EXPECT_THAT(record.Output(),
              HasSubstr("lost: 0 dropped, 0 unwritten; frame numbers missing: none"));
  EXPECT_GE(Logs(logs).size(), 3U);
  std::vector<int64_t> seqs;
  for (const fs::path& log : Logs(logs)) {
    EXPECT_LE(fs::file_size(log), 1'010'000U);
    EXPECT_TRUE(Summarise(log).ends_with_it);
    const std::vector<int64_t> more = SeqsOf(ReadChannels(log), Part::kRight, "A_");
    seqs.insert(seqs.end(), more.begin(), more.end());
  }
  EXPECT_GE(seqs.size(), 80U);
  EXPECT_TRUE(AreConsecutive(seqs));
  EXPECT_EQ(Summarise(Logs(logs).back()).status.state, StageStatus::State::kStopped);
}

TEST_F(RecordRobot, KeepsTheNewestWithinItsQuota) {
  const fs::path logs = folder_ / "logs";
  Graph graph;
  Process& record = graph.Start(
      "record", {"--dir", logs, "--quota-gb", "0.002", "--max-mb", "0.5", "--delete-oldest"});
  graph.Start("capture", kCamera);
  ASSERT_TRUE(HasRecorded(graph, 120));
  record.Signal(SIGINT);
  ASSERT_EQ(record.Wait(), 0) << record.Output();
  EXPECT_THAT(record.Output(), HasSubstr("older logs deleted"));
  EXPECT_LE(BytesOfAll(Logs(logs)), 2'010'000);
  EXPECT_GE(BytesOfAll(Logs(logs)), 1'000'000);
  EXPECT_FALSE(Logs(logs).front().filename().string().starts_with("record_000001_"));
  EXPECT_EQ(Summarise(Logs(logs).back()).status.state, StageStatus::State::kStopped);
}

TEST_F(RecordRobot, SaysThatTheDiskIsFullAndLeavesAReadableLog) {
  if (Process({"unshare", "--mount", "mount", "-t", "tmpfs", "tmpfs", "/mnt"}).Wait() != 0) {
    GTEST_SKIP() << "skipped: this kernel allows no private mount namespace";
  }
  fs::create_directory(folder_ / "disk");
  Graph graph;
  // The disk vanishes with the process, so its files are copied before.
  Process record({"unshare", "--mount", "sh", "-c",
                  "cd $1 && mount -t tmpfs -o size=3m tmpfs disk && $2 --dir disk; code=$?; "
                  "cp -r disk kept; exit $code",
                  "sh", folder_ / "", ProgramPath("sprout-record")});
  graph.Start("capture", kCamera);
  ASSERT_EQ(record.Wait(), 1) << record.Output();
  EXPECT_THAT(record.Output(), HasSubstr(".lcm: cannot be written (No space left on device)"));
  ASSERT_EQ(Logs(folder_ / "kept").size(), 1U) << record.Output();
  const fs::path log = Logs(folder_ / "kept")[0];
  EXPECT_THAT(Summarise(log).status.last_error, HasSubstr("No space left on device"));
  const std::vector<int64_t> seqs = SeqsOf(ReadChannels(log), Part::kLeft);
  EXPECT_GE(seqs.size(), 20U);
  EXPECT_TRUE(AreConsecutive(seqs));
}

// Its clock alone is set, as ntpd does when it has found the time.
TEST_F(RecordRobot, LosesNothingWhenItsClockIsSetOnAndBack) {
  const fs::path logs = folder_ / "logs";
  const fs::path offset_s = folder_ / "offset_s";
  const auto set_clock = [&](int64_t seconds) {
    std::ofstream(offset_s, std::ios::binary | std::ios::in | std::ios::out)
        .write(reinterpret_cast<const char*>(&seconds), sizeof seconds);
  };
  std::ofstream(offset_s) << std::string(sizeof(int64_t), '\0');
  Graph graph;
  Process record({"env", "LD_PRELOAD=" SPROUT_CLOCK_STEP,
                  "SPROUT_CLOCK_OFFSET_FILE=" + offset_s.string(), ProgramPath("sprout-record"),
                  "--dir", logs, "--ring", "3", "--after", "1"});
  graph.Start("capture", kCamera);
  const auto has_recorded = [&](int64_t frames) { return HasRecorded(graph, frames); };
  ASSERT_TRUE(has_recorded(40));
  set_clock(3600);
  ASSERT_TRUE(has_recorded(60));
  set_clock(-7200);
  ASSERT_TRUE(has_recorded(80));
  record.Signal(SIGUSR1);
  ASSERT_TRUE(has_recorded(120));
  record.Signal(SIGINT);
  ASSERT_EQ(record.Wait(), 0) << record.Output();
  ASSERT_EQ(Logs(logs).size(), 1U) << record.Output();
  const fs::path log = Logs(logs)[0];
  const std::vector<int64_t> seqs = SeqsOf(ReadChannels(log), Part::kLeft);
  EXPECT_TRUE(AreConsecutive(seqs));
  EXPECT_NEAR(static_cast<double>(seqs.size()), (3 + 1) * 20, 10);  // by a clock that nobody sets
  std::vector<double> steps_s = ClockSteps(log);
  ASSERT_EQ(steps_s.size(), 2U);
  EXPECT_NEAR(steps_s[0], 3600, 1);
  EXPECT_NEAR(steps_s[1], -3 * 3600, 1);

  const fs::path answers = folder_ / "answers.lcm";
  Replay("sprout-refine", "default", {log}, answers);
  EXPECT_GE(SeqsOf(ReadChannels(answers), Part::kSeeds).size(), seqs.size() - 5);
}

TEST_F(RecordRobot, SaysThatTheFolderHasVanished) {
  const fs::path logs = folder_ / "logs";
  Graph graph;
  Process& record = graph.Start("record", {"--dir", logs});
  graph.Start("capture", kCamera);
  ASSERT_TRUE(HasRecorded(graph, 20));
  fs::rename(logs, folder_ / "elsewhere");
  ASSERT_EQ(record.Wait(), 1) << record.Output();
  EXPECT_THAT(record.Output(), HasSubstr("logs: has vanished"));
  EXPECT_THAT(Summarise(Logs(folder_ / "elsewhere")[0]).status.last_error, HasSubstr("vanished"));
}

TEST_F(RecordRobot, RefusesFlagsThatCannotWork) {
  const fs::path logs = folder_ / "logs";
  const auto output_of = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"sprout-record", "--dir", logs});
    return OutputOf(flags, 2);
  };
  EXPECT_THAT(output_of({"--after", "3"}), HasSubstr("--after requires --ring"));
  EXPECT_THAT(output_of({"--channels", "SPROUT_.*"}), HasSubstr("--channels 'SPROUT_.*': allowed"));
  EXPECT_THAT(output_of({"--quota-gb", "1", "--delete-oldest"}),
              HasSubstr("--max-mb 1000: allowed with --delete-oldest is up to half"));
  EXPECT_THAT(output_of({"--ring", "nan"}), HasSubstr("--ring"));
  EXPECT_FALSE(fs::exists(logs));
}

}  // namespace
}  // namespace sprout
