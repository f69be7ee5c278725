// sprout-batch with the real stages, on this machine and with a real Slurm (slurm_cluster).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <thread>

#include "common/logfile/log_reader.h"
#include "services/batch/manifest.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/system/batch_logs.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string ProgramPath(const std::string& name) {
  return (fs::path(SPROUT_BINARY_DIR) / name).string();
}

struct Outcome {
  int exit_code;
  std::string output;
};

Outcome RunProgramOf(const std::vector<std::string>& words) {
  std::vector<std::string> command = words;
  command[0] = ProgramPath(words[0]);
  Process process(command);
  const int code = process.Wait(std::chrono::seconds(240)).value_or(-1);
  return {code, process.Output()};
}

bool Eventually(const std::function<bool()>& condition, std::chrono::seconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return true;
}

// What the three stages record over a whole log on one machine, merged.
std::string WholeReplay(const fs::path& folder, const fs::path& log) {
  std::vector<std::string> replays = {"--replay", log};
  std::vector<std::string> records;
  for (const std::string stage : {"refine", "prior", "grow"}) {
    records.push_back(folder / ("whole_" + stage + ".lcm"));
    std::vector<std::string> command = {"sprout-" + stage, "--config", "fast", "--record",
                                        records.back()};
    command.insert(command.end(), replays.begin(), replays.end());
    const Outcome outcome = RunProgramOf(command);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    replays.insert(replays.end(), {"--replay", records.back()});
  }
  const std::string merged = folder / "whole.lcm";
  const Outcome outcome = RunProgramOf(
      {"sprout-log", "merge", records[0], records[1], records[2], "--out", merged, "--force"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  return BytesOfFile(merged);
}

int64_t CountResults(const fs::path& out) {
  std::error_code error;
  int64_t count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(out / "results", error)) {
    if (entry.path().filename() == "run.json" &&
        entry.path().string().find(".part-") == std::string::npos) {
      ++count;
    }
  }
  return count;
}

std::vector<std::string> RunCommand(const fs::path& logs, const fs::path& out) {
  return {"sprout-batch",
          "run",
          logs,
          "--out",
          out,
          "--config",
          "fast",
          "--keep",
          "refine,prior,grow",
          "--shard-megabytes",
          "1"};
}

TEST(BatchSystem, MergedAnswersAreTheBytesOfAReplayOfTheWholeLog) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs" / "run.lcm", "320x240", 0, 24);
  const Outcome outcome = RunProgramOf(RunCommand(folder / "logs", folder / "out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const Manifest manifest = ReadManifest(folder / "out" / "manifest.jsonl");
  EXPECT_GE(manifest.shards.size(), 3U);
  EXPECT_THAT(manifest.shards[1].carried, testing::Not(testing::IsEmpty()));
  const std::string merged = BytesOfFile(folder / "out" / "logs" / "run_a.lcm");
  EXPECT_GT(merged.size(), 1000U);
  EXPECT_TRUE(merged == WholeReplay(folder / "", folder / "logs" / "run.lcm"));
}

TEST(BatchSystem, TheSameCommandAgainDoesWhatIsMissingAndNothingElse) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs" / "run.lcm", "320x240", 0, 16);
  const auto command = RunCommand(folder / "logs", folder / "out");
  ASSERT_EQ(RunProgramOf(command).exit_code, 0);
  const auto whole = BytesOfFile(folder / "out" / "logs" / "run_a.lcm");
  EXPECT_THAT(RunProgramOf(command).output, HasSubstr("shards were done already"));

  const Manifest manifest = ReadManifest(folder / "out" / "manifest.jsonl");
  const BatchFolder batch(folder / "out");
  fs::remove_all(
      batch.result(ResultKey(manifest.head, manifest.head.variants[0], manifest.shards[1])));
  const int64_t before = CountResults(folder / "out");
  const Outcome again = RunProgramOf(command);
  EXPECT_THAT(again.output, HasSubstr(", 1 of them to do"));
  EXPECT_EQ(CountResults(folder / "out"), before + 1);
  EXPECT_TRUE(BytesOfFile(folder / "out" / "logs" / "run_a.lcm") == whole);

  // Another configuration B computes B alone, and compares.
  auto compare = command;
  std::ofstream(folder / "b.textproto") << "grow { sigma_p_px: 3.0 }\n";
  compare.insert(compare.end(), {"--config-b", "fast", "--config-b", folder / "b.textproto"});
  const Outcome compared = RunProgramOf(compare);
  EXPECT_EQ(compared.exit_code, 0) << compared.output;
  EXPECT_EQ(CountResults(folder / "out"), 2 * (before + 1));
  const std::string report = BytesOfFile(folder / "out" / "report.html");
  EXPECT_THAT(report, HasSubstr("The most changed frames"));
  EXPECT_THAT(report, HasSubstr("sigma_p_px: 3"));
  EXPECT_THAT(report, HasSubstr("data:image/jpeg;base64,"));
  EXPECT_THAT(report, testing::ContainsRegex("sprout-view --log [^ ]*run.lcm --frame [0-9]+\n"));
}

TEST(BatchSystem, CtrlCLeavesWhatIsWholeAndTheSameCommandGoesOn) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs" / "run.lcm", "320x240", 0, 24);
  auto command = RunCommand(folder / "logs", folder / "out");
  command.insert(command.end(), {"--jobs", "1"});
  auto absolute = command;
  absolute[0] = ProgramPath(command[0]);
  {
    Process process(absolute);
    ASSERT_TRUE(
        Eventually([&] { return CountResults(folder / "out") > 0; }, std::chrono::seconds(60)))
        << process.Output();
    process.Signal(SIGINT);
    EXPECT_EQ(process.Wait(), 130) << process.Output();
  }
  EXPECT_FALSE(fs::exists(folder / "out" / "logs"));
  const Outcome outcome = RunProgramOf(command);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(BytesOfFile(folder / "out" / "logs" / "run_a.lcm") ==
              WholeReplay(folder / "", folder / "logs" / "run.lcm"));
}

// Run inside slurm_cluster, which kills nothing by itself.
TEST(BatchSlurm, TwelveLogsGiveTheBytesOfTheLocalEngineThoughANodeAndATaskAreKilled) {
  const char* state = std::getenv("SLURM_STATE");
  if (state == nullptr) GTEST_SKIP() << "no Slurm: run it in tests/system/slurm_cluster";
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  for (int i = 0; i < 12; ++i) {
    WriteStraddlingLog(folder / "logs" / ("run" + std::to_string(i) + ".lcm").c_str(), "160x120",
                       10 * i, 30);
  }
  const fs::path local = folder / "local";
  const fs::path slurm = folder / "slurm";
  ASSERT_EQ(RunProgramOf(RunCommand(folder / "logs", local)).exit_code, 0);
  auto command = RunCommand(folder / "logs", slurm);
  command.insert(command.end(), {"--engine", "slurm", "--memory", "500M", "--time", "10",
                                 "--array-size", "6", "--partition", "test"});
  const Outcome submitted = RunProgramOf(command);
  ASSERT_EQ(submitted.exit_code, 0) << submitted.output;
  EXPECT_THAT(RunProgramOf(command).output, HasSubstr("work there; wait, or scancel"));

  // In the middle: a node dies with what it works on, and a task is killed on the other.
  ASSERT_TRUE(Eventually([&] { return CountResults(slurm) > 0; }, std::chrono::seconds(90)));
  ASSERT_EQ(std::system("kill -9 $(cat $SLURM_STATE/node2.pid) &&"
                        "pgrep -f 'sprout-batch.? run-shar[d]' | head -n 1 | xargs -r kill -9"),
            0);
  EXPECT_TRUE(Eventually(
      [&] {
        return fs::exists(slurm / "report.html") &&
               RunProgramOf({"sprout-batch", "status", slurm}).exit_code == 0 &&
               std::distance(fs::directory_iterator(slurm / "logs"), {}) == 24;
      },
      std::chrono::seconds(180)))
      << RunProgramOf({"sprout-batch", "status", slurm}).output;
  for (int i = 0; i < 12; ++i) {
    const std::string name = "run" + std::to_string(i) + "_a.lcm";
    const std::string bytes = BytesOfFile(slurm / "logs" / name);
    EXPECT_GT(bytes.size(), 1000U) << name;
    EXPECT_TRUE(bytes == BytesOfFile(local / "logs" / name)) << name;
  }
}

}  // namespace
}  // namespace sprout
