// sprout-batch with the real stages, on this machine and with a real Slurm (slurm_cluster).
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>

#include "common/logfile/log_reader.h"
#include "services/tools/batch/manifest.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/system/batch_run.h"
#include "tests/system/eventually.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

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
  return FileText(merged);
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

TEST(BatchSystem, AnswersAreTheBytesOfReplaysByHand) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs" / "run.lcm", "320x240", 0, 24);
  const Outcome outcome = RunProgramOf(RunCommand(folder / "logs", folder / "out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const std::string merged = FileText(folder / "out" / "logs" / "run_a.lcm");
  EXPECT_GT(merged.size(), 1000U);
  EXPECT_TRUE(merged == WholeReplay(folder / "", folder / "logs" / "run.lcm"));

  // Other programs that answer the same.
  fs::create_directory(folder / "bin");
  for (const std::string stage : {"sprout-refine", "sprout-prior", "sprout-grow"}) {
    WriteProgram(folder / "bin" / stage.c_str(), "exec " + ProgramPath(stage) + " \"$@\"\n");
  }
  auto command = RunCommand(folder / "logs", folder / "out");
  command.insert(command.end(), {"--programs-b", folder / "bin"});
  const Outcome compared = RunProgramOf(command);
  EXPECT_EQ(compared.exit_code, 0) << compared.output;
  EXPECT_TRUE(merged == FileText(folder / "out" / "logs" / "run_b.lcm"));
  EXPECT_THAT(FileText(folder / "out" / "report.html"), HasSubstr("A and B give the same maps"));
}

TEST(BatchSystem, FusedMapsAreTheBytesOfReplaysByHand) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  const std::string log = folder / "logs" / "run.lcm";
  WriteStraddlingLog(log, "240x180", 0, 16);
  const Outcome outcome =
      RunProgramOf({"sprout-batch", "run", folder / "logs", "--out", folder / "out", "--stages",
                    "refine,prior,grow,temporal", "--config", "default", "--config-b", "default",
                    "--config-b", "temporal { min_gain: 1 }"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;

  std::vector<std::string> replays = {"--replay", log};
  std::string whole;
  for (const std::string stage : {"refine", "prior", "grow", "temporal"}) {
    whole = folder / (stage + ".lcm").c_str();
    std::vector<std::string> command = {"sprout-" + stage, "--config", "default", "--record",
                                        whole};
    command.insert(command.end(), replays.begin(), replays.end());
    ASSERT_EQ(RunProgramOf(command).exit_code, 0) << stage;
    replays.insert(replays.end(), {"--replay", whole});
  }
  EXPECT_TRUE(FileText(folder / "out" / "logs" / "run_a.lcm") == FileText(whole));
  // A and B differ from the third frame that has an answer on, not in the first.
  const auto changed = ColumnOf(folder / "out", "changed");
  const auto shares = ColumnOf(folder / "out", "a_valid_share");
  ASSERT_EQ(changed.size(), 14U);
  EXPECT_EQ(changed.front(), 0);
  EXPECT_GT(changed.back(), 0);
  EXPECT_GT(shares.back(), 0.9);
}

TEST(BatchSystem, TheSameCommandAgainDoesWhatIsMissingAndNothingElse) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs" / "run.lcm", "320x240", 0, 16);
  WriteStraddlingLog(folder / "logs" / "two.lcm", "160x120", 16, 5);
  const auto command = RunCommand(folder / "logs", folder / "out");
  ASSERT_EQ(RunProgramOf(command).exit_code, 0);
  const auto whole = FileText(folder / "out" / "logs" / "run_a.lcm");
  EXPECT_THAT(RunProgramOf(command).output, HasSubstr("2 logs, 0 of them to do"));

  const batch::Manifest manifest = batch::ReadManifest(folder / "out" / "manifest.textproto");
  fs::remove_all(batch::BatchFolder(folder / "out").result(manifest, 0, 0));
  const Outcome again = RunProgramOf(command);
  EXPECT_THAT(again.output, HasSubstr("2 logs, 1 of them to do"));
  EXPECT_EQ(CountResults(folder / "out"), 2);
  EXPECT_TRUE(FileText(folder / "out" / "logs" / "run_a.lcm") == whole);

  // A log that changed is another one.
  WriteStraddlingLog(folder / "logs" / "two.lcm", "160x120", 21, 5);
  EXPECT_THAT(RunProgramOf(command).output, HasSubstr("2 logs, 1 of them to do"));
  EXPECT_EQ(CountResults(folder / "out"), 3);

  // Another configuration B computes B alone, and compares.
  auto compare = command;
  std::ofstream(folder / "b.textproto") << "grow { sigma_p_px: 3.0 }\n";
  compare.insert(compare.end(), {"--config-b", "fast", "--config-b", folder / "b.textproto"});
  const Outcome compared = RunProgramOf(compare);
  EXPECT_EQ(compared.exit_code, 0) << compared.output;
  EXPECT_EQ(CountResults(folder / "out"), 3 + 2);
  const std::string report = FileText(folder / "out" / "report.html");
  EXPECT_THAT(report, HasSubstr("The most changed frames"));
  EXPECT_THAT(report, HasSubstr("sigma_p_px: 3"));
  EXPECT_THAT(report, HasSubstr("data:image/jpeg;base64,"));
  EXPECT_THAT(report, testing::ContainsRegex("sprout-view --log [^ ]*run.lcm --frame [0-9]+\n"));
}

TEST(BatchSystem, CtrlCLeavesWhatIsWholeAndTheSameCommandGoesOn) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs" / "a.lcm", "160x120", 0, 5);
  WriteStraddlingLog(folder / "logs" / "run.lcm", "320x240", 0, 120);  // takes a second
  auto command = RunCommand(folder / "logs", folder / "out");
  command.insert(command.end(), {"--jobs", "1"});
  auto absolute = command;
  absolute[0] = ProgramPath(command[0]);
  {
    Process process(absolute);
    ASSERT_TRUE(Eventually([&] { return fs::exists(folder / "out" / "manifest.textproto"); }));
    const Outcome second = RunProgramOf(command);
    EXPECT_EQ(second.exit_code, 2);
    EXPECT_THAT(second.output, HasSubstr("another sprout-batch is running there"));
    ASSERT_TRUE(
        Eventually([&] { return CountResults(folder / "out") > 0; }, std::chrono::seconds(60)))
        << process.Output();
    process.Signal(SIGINT);
    EXPECT_EQ(process.Wait(), 130) << process.Output();
  }
  EXPECT_FALSE(fs::exists(folder / "out" / "report.html"));
  const Outcome outcome = RunProgramOf(command);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("2 logs, 1 of them to do"));
  EXPECT_TRUE(FileText(folder / "out" / "logs" / "run_a.lcm") ==
              WholeReplay(folder / "", folder / "logs" / "run.lcm"));
}

TEST(BatchSystem, ALogWithoutACompleteFrameIsListedAndIsNoFailure) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs" / "run.lcm", "160x120", 0, 5);
  LogWriter writer(folder / "logs" / "other.lcm");
  writer.Write(1, "OTHER", {});
  writer.Close();
  const auto command = RunCommand(folder / "logs", folder / "out");
  const Outcome outcome = RunProgramOf(command);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(ColumnOf(folder / "out", "seq").size(), 5U);
  EXPECT_THAT(FileText(folder / "out" / "report.html"), HasSubstr("<tr><td>other</td><td>1<"));
  EXPECT_THAT(RunProgramOf(command).output, HasSubstr("2 logs, 0 of them to do"));
  // Alone it is one: probably flags are wrong.
  fs::remove(folder / "logs" / "run.lcm");
  const Outcome alone = RunProgramOf(command);
  EXPECT_EQ(alone.exit_code, 1);
  EXPECT_THAT(alone.output, HasSubstr("no frame was answered in these logs"));
  // What is no log stops the command before anything is computed.
  std::ofstream(folder / "logs" / "text.lcm") << "no log at all\n";
  EXPECT_EQ(RunProgramOf(command).exit_code, 2);
}

TEST(BatchSystem, ATruthSaysWhichOfTheTwoIsNearerToIt) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs" / "run.lcm", "320x240", 0, 12);
  auto command = RunCommand(folder / "logs", folder / "out");
  ASSERT_EQ(RunProgramOf(command).exit_code, 0);
  // A's own maps are the truth, so A has no error; of frame 3 none is known.
  const fs::path truth = folder / "truth";
  fs::create_directory(truth);
  const Outcome exported = RunProgramOf(
      {"sprout-log", "export", "--pfm", folder / "out" / "logs" / "run_a.lcm", truth / "run"});
  ASSERT_EQ(exported.exit_code, 0) << exported.output;
  ASSERT_TRUE(fs::remove(truth / "run" / "000003_disparity.pfm"));
  std::ofstream(folder / "b.textproto") << "grow { sigma_p_px: 9.0 fill: NONE }\n";
  command.insert(command.end(),
                 {"--config-b", "fast", "--config-b", folder / "b.textproto", "--truth", truth});
  const Outcome compared = RunProgramOf(command);
  ASSERT_EQ(compared.exit_code, 0) << compared.output;
  const std::vector<double> a = ColumnOf(folder / "out", "a_bad1");
  const std::vector<double> b = ColumnOf(folder / "out", "b_bad1");
  ASSERT_EQ(a.size(), 11U);  // frame 5 is incomplete
  for (size_t i = 0; i < a.size(); ++i) {
    if (i == 3) {
      EXPECT_TRUE(std::isnan(a[i]) && std::isnan(b[i]));
    } else {
      EXPECT_EQ(a[i], 0);
      EXPECT_GT(b[i], 0);
    }
  }
  EXPECT_THAT(FileText(folder / "out" / "report.html"), HasSubstr("against the truth"));
  command.back() = folder / "none";
  EXPECT_EQ(RunProgramOf(command).exit_code, 2);
}

TEST(BatchSystem, FramesAreComparedWithoutBeingMeasured) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs" / "run.lcm", "160x120", 0, 5);
  std::ofstream(folder / "b.textproto") << "grow { sigma_p_px: 9.0 }\n";
  auto command = RunCommand(folder / "logs", folder / "out");
  command.insert(command.end(), {"--config-b", "fast", "--config-b", folder / "b.textproto"});
  ASSERT_EQ(RunProgramOf(command).exit_code, 0);
  const auto moved = ColumnOf(folder / "out", "moved");
  EXPECT_EQ(moved.size(), 5U);
  EXPECT_FALSE(std::isnan(ColumnOf(folder / "out", "a_score").at(0)));
  command.emplace_back("--no-measures");
  const Outcome outcome = RunProgramOf(command);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(ColumnOf(folder / "out", "moved"), moved);
  for (const double score : ColumnOf(folder / "out", "a_score")) EXPECT_TRUE(std::isnan(score));
  const std::string report = FileText(folder / "out" / "report.html");
  EXPECT_THAT(report, HasSubstr("The most changed frames"));
  EXPECT_THAT(report, testing::Not(HasSubstr("The worst frames")));
}

TEST(BatchSystem, AnotherBuildIsComparedAndItsFailuresAreReported) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs" / "run.lcm", "320x240", 0, 16);
  auto command = RunCommand(folder / "logs", folder / "out");
  command.insert(command.end(), {"--programs-b", folder / "bin"});
  const Outcome without = RunProgramOf(command);
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_THAT(without.output, HasSubstr("sprout-refine: cannot be run"));

  // Another grow; and a prior that fails once.
  fs::create_directory(folder / "bin");
  fs::copy_file(ProgramPath("sprout-refine"), folder / "bin" / "sprout-refine");
  std::ofstream(folder / "b.textproto") << "grow { sigma_p_px: 9.0 }\n";
  WriteProgram(folder / "bin" / "sprout-grow", "exec " + ProgramPath("sprout-grow") +
                                                   " \"$@\" --config " +
                                                   (folder / "b.textproto").string() + "\n");
  WriteProgram(folder / "bin" / "sprout-prior",
               "if [ \"$1\" != --version ] && mkdir " + (folder / "failed").string() +
                   " 2> /dev/null; then echo no luck today; exit 3; fi\nexec " +
                   ProgramPath("sprout-prior") + " \"$@\"\n");
  const Outcome outcome = RunProgramOf(command);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output,
              HasSubstr("sprout-prior ended with exit code 3: no luck today; will be "
                        "tried again"));
  for (const double moved : ColumnOf(folder / "out", "moved")) EXPECT_GT(moved, 0);
  const std::string report = FileText(folder / "out" / "report.html");
  EXPECT_THAT(report, HasSubstr("The configurations are the same; the programs differ."));
  EXPECT_THAT(report, HasSubstr((folder / "bin" / "sprout-grow").string() + " --config"));
  EXPECT_THAT(report, HasSubstr("done after 1 failed try"));
  EXPECT_THAT(report, HasSubstr("no luck today"));
}

void ReplaceAll(std::string& text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

// What somebody copies from under "compute it again", of the first frame that is shown.
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

TEST(BatchSystem, TheReportsCommandsComputeAFrameOfALogWithAShellsNameAgain) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs/x'$(touch PWNED)'.lcm", "160x120", 0, 5);
  const Outcome outcome = RunProgramOf(RunCommand(folder / "logs", folder / "out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  std::string commands = FirstCommands(FileText(folder / "out" / "report.html"));
  ASSERT_THAT(commands, HasSubstr("touch PWNED"));
  ASSERT_THAT(commands, HasSubstr("sprout-view"));
  commands.erase(0, commands.find('\n') + 1);  // it would wait for a browser
  fs::create_directory(folder / "work");
  const std::string lines = "set -e; cd '" + (folder / "work").string() + "'\n" + commands;
  Process shell({"sh", "-c", lines});
  EXPECT_EQ(shell.Wait(std::chrono::seconds(60)), 0) << shell.Output();
  EXPECT_GT(fs::file_size(folder / "work/grow_a.lcm"), 1000U);
  EXPECT_FALSE(fs::exists(folder / "work/PWNED"));
}

TEST(BatchSystem, LogsWhoseNamesCannotBeUsedAreNamedAndTheOthersComputed) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs/a.lcm", "160x120", 0, 5);
  fs::copy_file(folder / "logs/a.lcm", folder / "logs/b\xe4.lcm");
  fs::copy_file(folder / "logs/a.lcm", folder / "logs/c\nd.lcm");
  const auto command = RunCommand(folder / "logs", folder / "out");
  const Outcome outcome = RunProgramOf(command);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("left out: "));
  EXPECT_THAT(outcome.output, HasSubstr("b\\xe4.lcm: is not allowed in the manifest"));
  EXPECT_THAT(outcome.output, HasSubstr("c\\x0ad.lcm: is not allowed in the manifest"));
  EXPECT_THAT(outcome.output, testing::Not(HasSubstr("will be tried again")));
  EXPECT_GT(fs::file_size(folder / "out/logs/a_a.lcm"), 1000U);
  EXPECT_THAT(FileText(folder / "out" / "report.html"), HasSubstr("b\\xe4.lcm"));
  const Outcome status = RunProgramOf({"sprout-batch", "status", folder / "out"});
  EXPECT_EQ(status.exit_code, 1);
  EXPECT_THAT(status.output, HasSubstr("c\\x0ad.lcm"));
  const Outcome prefix = RunProgramOf(
      {"sprout-batch", "run", folder / "logs", "--out", folder / "o2", "--channel-prefix", "x'y"});
  EXPECT_EQ(prefix.exit_code, 2);
  EXPECT_THAT(prefix.output, HasSubstr("--channel-prefix 'x'y': allowed are up to"));
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
