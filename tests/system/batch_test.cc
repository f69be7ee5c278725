// sprout-batch with the real stages, on this machine and with a real Slurm (slurm_cluster).
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <fstream>

#include "common/logfile/log_reader.h"
#include "services/tools/batch/manifest.h"
#include "tests/common/testing/test_with_folder.h"
#include "tests/system/batch_run.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// What the last of the three stages records over a whole log on one machine.
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
  return FileText(records.back());
}

int64_t CountResults(const fs::path& out) {
  std::error_code error;
  int64_t count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(out / "results", error)) {
    if (entry.path().filename() == "runs.textproto" &&
        entry.path().string().find(".part-") == std::string::npos) {
      ++count;
    }
  }
  return count;
}

void WriteProgram(const fs::path& path, const std::string& lines) {
  std::ofstream(path) << "#!/bin/sh\n" << lines;
  fs::permissions(path, fs::perms::owner_all);
}

class BatchSystem : public TestWithFolder {
 protected:
  BatchSystem() { fs::create_directory(logs_); }

  std::string Report() const { return FileText(out_ / "report.html"); }

  const fs::path logs_ = folder_ / "logs";
  const fs::path out_ = folder_ / "out";
  std::vector<std::string> command_ = RunCommand(logs_, out_);
};

TEST_F(BatchSystem, AnswersAreTheBytesOfReplaysByHand) {
  WriteStraddlingLog(logs_ / "run.lcm", "320x240", 0, 24);
  const Outcome outcome = RunProgramOf(command_);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const std::string answers = FileText(out_ / "logs" / "run_a.lcm");
  EXPECT_GT(answers.size(), 1000U);
  EXPECT_TRUE(answers == WholeReplay(folder_ / "", logs_ / "run.lcm"));

  // Other programs that answer the same.
  fs::create_directory(folder_ / "bin");
  for (const std::string stage : {"sprout-refine", "sprout-prior", "sprout-grow"}) {
    WriteProgram(folder_ / "bin" / stage.c_str(), "exec " + ProgramPath(stage) + " \"$@\"\n");
  }
  command_.insert(command_.end(), {"--programs-b", folder_ / "bin"});
  const Outcome compared = RunProgramOf(command_);
  EXPECT_EQ(compared.exit_code, 0) << compared.output;
  EXPECT_TRUE(answers == FileText(out_ / "logs" / "run_b.lcm"));
  EXPECT_THAT(Report(), HasSubstr("A and B give the same maps"));
}

TEST_F(BatchSystem, FusedMapsAreTheBytesOfReplaysByHand) {
  const std::string log = logs_ / "run.lcm";
  WriteStraddlingLog(log, "240x180", 0, 16);
  const Outcome outcome = RunProgramOf(
      {"sprout-batch", "run", logs_, "--out", out_, "--stages", "refine,prior,grow,temporal",
       "--config", "default", "--config-b", "default", "--config-b", "temporal { min_gain: 1 }"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;

  std::vector<std::string> replays = {"--replay", log};
  std::string whole;
  for (const std::string stage : {"refine", "prior", "grow", "temporal"}) {
    whole = folder_ / (stage + ".lcm").c_str();
    std::vector<std::string> command = {"sprout-" + stage, "--config", "default", "--record",
                                        whole};
    command.insert(command.end(), replays.begin(), replays.end());
    ASSERT_EQ(RunProgramOf(command).exit_code, 0) << stage;
    replays.insert(replays.end(), {"--replay", whole});
  }
  EXPECT_TRUE(FileText(out_ / "logs" / "run_a.lcm") == FileText(whole));
  // A and B differ from the third frame that has an answer on, not in the first.
  const auto changed = ColumnOf(out_, "changed");
  const auto shares = ColumnOf(out_, "a_valid_share");
  ASSERT_EQ(changed.size(), 14U);
  EXPECT_EQ(changed.front(), 0);
  EXPECT_GT(changed.back(), 0);
  EXPECT_GT(shares.back(), 0.9);
}

TEST_F(BatchSystem, TheSameCommandAgainDoesWhatIsMissingAndNothingElse) {
  WriteStraddlingLog(logs_ / "run.lcm", "320x240", 0, 16);
  WriteStraddlingLog(logs_ / "two.lcm", "160x120", 16, 5);
  ASSERT_EQ(RunProgramOf(command_).exit_code, 0);
  const auto whole = FileText(out_ / "logs" / "run_a.lcm");
  EXPECT_THAT(RunProgramOf(command_).output, HasSubstr("2 logs, 0 of them to do"));

  const batch::Manifest manifest = batch::ReadManifest(out_ / "manifest.textproto");
  fs::remove_all(batch::BatchFolder(out_).result(manifest, 0, 0));
  const Outcome again = RunProgramOf(command_);
  EXPECT_THAT(again.output, HasSubstr("2 logs, 1 of them to do"));
  EXPECT_EQ(CountResults(out_), 2);
  EXPECT_TRUE(FileText(out_ / "logs" / "run_a.lcm") == whole);

  // A log that changed is another one.
  WriteStraddlingLog(logs_ / "two.lcm", "160x120", 21, 5);
  EXPECT_THAT(RunProgramOf(command_).output, HasSubstr("2 logs, 1 of them to do"));
  EXPECT_EQ(CountResults(out_), 3);

  // Another configuration B computes B alone, and compares.
  auto compare = command_;
  std::ofstream(folder_ / "b.textproto") << "grow { sigma_p_px: 3.0 }\n";
  compare.insert(compare.end(), {"--config-b", "fast", "--config-b", folder_ / "b.textproto"});
  const Outcome compared = RunProgramOf(compare);
  EXPECT_EQ(compared.exit_code, 0) << compared.output;
  EXPECT_EQ(CountResults(out_), 3 + 2);
  const std::string report = Report();
  EXPECT_THAT(report, HasSubstr("The most changed frames"));
  EXPECT_THAT(report, HasSubstr("sigma_p_px: 3"));
  EXPECT_THAT(report, HasSubstr("data:image/jpeg;base64,"));
  EXPECT_THAT(report, testing::ContainsRegex("sprout-view --log [^ ]*run.lcm --frame [0-9]+\n"));
}

TEST_F(BatchSystem, CtrlCLeavesWhatIsWholeAndTheSameCommandGoesOn) {
  WriteStraddlingLog(logs_ / "a.lcm", "160x120", 0, 5);
  WriteStraddlingLog(logs_ / "run.lcm", "320x240", 0, 120);  // takes a second
  command_.insert(command_.end(), {"--jobs", "1"});
  auto absolute = command_;
  absolute[0] = ProgramPath(command_[0]);
  {
    Process process(absolute);
    ASSERT_TRUE(Eventually([&] { return fs::exists(out_ / "manifest.textproto"); }));
    EXPECT_THAT(OutputOf(command_, 2), HasSubstr("another sprout-batch is running there"));
    ASSERT_TRUE(Eventually([&] { return CountResults(out_) > 0; }, std::chrono::seconds(60)))
        << process.Output();
    process.Signal(SIGINT);
    EXPECT_EQ(process.Wait(), 130) << process.Output();
  }
  EXPECT_FALSE(fs::exists(out_ / "report.html"));
  EXPECT_THAT(OutputOf(command_), HasSubstr("2 logs, 1 of them to do"));
  EXPECT_TRUE(FileText(out_ / "logs" / "run_a.lcm") ==
              WholeReplay(folder_ / "", logs_ / "run.lcm"));
}

TEST_F(BatchSystem, ALogWithoutACompleteFrameIsListedAndIsNoFailure) {
  WriteStraddlingLog(logs_ / "run.lcm", "160x120", 0, 5);
  LogWriter writer(logs_ / "other.lcm");
  writer.Write(1, "OTHER", {});
  writer.Close();
  const Outcome outcome = RunProgramOf(command_);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(ColumnOf(out_, "seq").size(), 5U);
  EXPECT_THAT(Report(), HasSubstr("<tr><td>other</td><td>1<"));
  EXPECT_THAT(outcome.output, HasSubstr("1 of 2 logs have no frame with an answer; the report"));
  EXPECT_THAT(RunProgramOf(command_).output, HasSubstr("2 logs, 0 of them to do"));
  // Alone it is one: probably flags are wrong.
  fs::remove(logs_ / "run.lcm");
  EXPECT_THAT(OutputOf(command_, 1), HasSubstr("no frame was answered in these logs"));
  // A file that is no log stops the command before anything is computed.
  std::ofstream(logs_ / "text.lcm") << "no log at all\n";
  EXPECT_EQ(RunProgramOf(command_).exit_code, 2);
}

TEST_F(BatchSystem, AnotherBuildIsComparedAndItsFailuresAreReported) {
  WriteStraddlingLog(logs_ / "run.lcm", "320x240", 0, 16);
  command_.insert(command_.end(), {"--programs-b", folder_ / "bin"});
  EXPECT_THAT(OutputOf(command_, 2), HasSubstr("sprout-refine: cannot be run"));

  // Another grow; and a prior that fails once.
  fs::create_directory(folder_ / "bin");
  fs::copy_file(ProgramPath("sprout-refine"), folder_ / "bin" / "sprout-refine");
  std::ofstream(folder_ / "b.textproto") << "grow { sigma_p_px: 9.0 }\n";
  WriteProgram(folder_ / "bin" / "sprout-grow", "exec " + ProgramPath("sprout-grow") +
                                                    " \"$@\" --config " +
                                                    (folder_ / "b.textproto").string() + "\n");
  WriteProgram(folder_ / "bin" / "sprout-prior",
               "if [ \"$1\" != --version ] && mkdir " + (folder_ / "failed").string() +
                   " 2> /dev/null; then echo no luck today; exit 3; fi\nexec " +
                   ProgramPath("sprout-prior") + " \"$@\"\n");
  EXPECT_THAT(OutputOf(command_),
              HasSubstr("sprout-prior ended with exit code 3: no luck today; will be tried again"));
  for (const double moved : ColumnOf(out_, "moved")) EXPECT_GT(moved, 0);
  const std::string report = Report();
  EXPECT_THAT(report, HasSubstr("The configurations are the same; the programs differ."));
  EXPECT_THAT(report, HasSubstr((folder_ / "bin" / "sprout-grow").string() + " --config"));
  EXPECT_THAT(report, HasSubstr("done after 1 failed try"));
  EXPECT_THAT(report, HasSubstr("no luck today"));
}

void ReplaceAll(std::string& text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

// The commands of the report's "compute it again", of the first frame that is shown.
std::string FirstCommands(const std::string& report) {
  const std::string begin = "compute it again</summary><pre>";
  const size_t at = report.find(begin) + begin.size();
  std::string text = report.substr(at, report.find("</pre>", at) - at);
  ReplaceAll(text, "&lt;", "<");
  ReplaceAll(text, "&gt;", ">");
  ReplaceAll(text, "&quot;", "\"");
  ReplaceAll(text, "&amp;", "&");
  return text;
}

TEST_F(BatchSystem, TheReportsCommandsComputeAFrameOfALogWithAShellsNameAgain) {
  WriteStraddlingLog(logs_ / "x'$(touch PWNED)'.lcm", "160x120", 0, 5);
  const Outcome outcome = RunProgramOf(command_);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  std::string commands = FirstCommands(Report());
  ASSERT_THAT(commands, HasSubstr("touch PWNED"));
  ASSERT_THAT(commands, HasSubstr("sprout-view"));
  commands.erase(0, commands.find('\n') + 1);  // it would wait for a browser
  fs::create_directory(folder_ / "work");
  const std::string lines = "set -e; cd '" + (folder_ / "work").string() + "'\n" + commands;
  Process shell({"sh", "-c", lines});
  EXPECT_EQ(shell.Wait(std::chrono::seconds(60)), 0) << shell.Output();
  EXPECT_GT(fs::file_size(folder_ / "work/grow_a.lcm"), 1000U);
  EXPECT_FALSE(fs::exists(folder_ / "work/PWNED"));
}

TEST_F(BatchSystem, ALogWhoseNameCannotBeUsedIsRefused) {
  WriteStraddlingLog(logs_ / "a.lcm", "160x120", 0, 5);
  fs::copy_file(logs_ / "a.lcm", logs_ / "b\xe4.lcm");
  EXPECT_THAT(OutputOf(command_, 2), HasSubstr("b\\xe4.lcm': allowed is UTF-8 without control"));
  ASSERT_TRUE(fs::remove(logs_ / "b\xe4.lcm"));
  const Outcome prefix = RunProgramOf(
      {"sprout-batch", "run", logs_, "--out", folder_ / "o2", "--channel-prefix", "x'y"});
  EXPECT_EQ(prefix.exit_code, 2);
  EXPECT_THAT(prefix.output, HasSubstr("--channel-prefix 'x'y': allowed are up to"));
}

TEST_F(BatchSystem, WhatIsRefusedLeavesNoFolder) {
  fs::create_directory(folder_ / "theirs");
  for (const char* out : {"new", "far/new", "theirs"}) {
    EXPECT_THAT(OutputOf({"sprout-batch", "run", logs_, "--out", folder_ / out}, 2),
                HasSubstr("no log (*.lcm) in this folder"));
  }
  EXPECT_FALSE(fs::exists(folder_ / "new"));
  EXPECT_FALSE(fs::exists(folder_ / "far"));
  EXPECT_TRUE(fs::exists(folder_ / "theirs"));
}

TEST_F(BatchSystem, FlagsOfSlurmAskForIt) {
  command_.insert(command_.end(), {"--partition", "short"});
  EXPECT_THAT(OutputOf(command_, 2), HasSubstr("--partition requires --engine"));
}

// Run inside slurm_cluster, which kills nothing by itself.
TEST(BatchSlurm, ThirtyLogsGiveTheBytesOfTheLocalEngineThoughANodeAndATaskAreKilled) {
  const char* state = std::getenv("SLURM_STATE");
  if (state == nullptr) GTEST_SKIP() << "no Slurm: run it in tests/system/slurm_cluster";
  constexpr int kLogs = 30;
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  for (int i = 0; i < kLogs; ++i) {
    WriteStraddlingLog(folder / "logs" / ("run" + std::to_string(i) + ".lcm").c_str(), "160x120",
                       10 * i, 10);
  }
  const fs::path local = folder / "local";
  const fs::path slurm = folder / "slurm";
  ASSERT_EQ(RunProgramOf(RunCommand(folder / "logs", local)).exit_code, 0);
  auto command = RunCommand(folder / "logs", slurm);
  command.insert(command.end(), {"--engine", "slurm", "--memory", "500M", "--time", "10",
                                 "--array-size", "6", "--partition", "test"});
  const Outcome submitted = RunProgramOf(command);
  ASSERT_EQ(submitted.exit_code, 0) << submitted.output;
  EXPECT_THAT(RunProgramOf(command).output, HasSubstr("; wait, or scancel"));

  // In the middle: a node dies with what it works on, and a task is killed on the other.
  ASSERT_TRUE(Eventually([&] { return CountResults(slurm) > 0; }, std::chrono::seconds(90)));
  ASSERT_EQ(std::system("kill -9 $(cat $SLURM_STATE/node2.pid) &&"
                        "pgrep -f 'sprout-batch.? comput[e]' | head -n 1 | xargs -r kill -9"),
            0);
  EXPECT_TRUE(Eventually(
      [&] {
        return fs::exists(slurm / "report.html") &&
               RunProgramOf({"sprout-batch", "status", slurm}).exit_code == 0 &&
               std::distance(fs::directory_iterator(slurm / "logs"), {}) == kLogs;
      },
      std::chrono::seconds(180)))
      << RunProgramOf({"sprout-batch", "status", slurm}).output;
  for (int i = 0; i < kLogs; ++i) {
    const std::string name = "run" + std::to_string(i) + "_a.lcm";
    const std::string bytes = FileText(slurm / "logs" / name);
    EXPECT_GT(bytes.size(), 1000U) << name;
    EXPECT_TRUE(bytes == FileText(local / "logs" / name)) << name;
  }
}

}  // namespace
}  // namespace sprout
