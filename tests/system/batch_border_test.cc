// sprout-batch over logs with odd names, damaged results and a manifest from elsewhere.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/tools/batch/log_task.h"
#include "services/tools/batch/manifest.h"
#include "tests/common/picture/temporary_directory.h"
#include "tests/system/batch_logs.h"
#include "tests/system/batch_run.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using batch::kAnswers;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

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

TEST(BatchBorder, LogsWithAlikeNamesKeepAllTheirFrames) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs/run_1.lcm", "160x120", 0, 5);
  WriteStraddlingLog(folder / "logs/run,1.lcm", "160x120", 5, 4);
  const Outcome outcome = RunProgramOf(RunCommand(folder / "logs", folder / "out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(ColumnOf(folder / "out", "seq"), SizeIs(9));
  EXPECT_GT(fs::file_size(folder / "out/logs/run_1_a.lcm"), 1000U);
  EXPECT_GT(fs::file_size(folder / "out/logs/run_1-2_a.lcm"), 1000U);
}

TEST(BatchBorder, TheReportsCommandsComputeAFrameOfALogWithAShellsNameAgain) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "logs");
  WriteStraddlingLog(folder / "logs/x'$(touch PWNED)'.lcm", "160x120", 0, 5);
  const Outcome outcome = RunProgramOf(RunCommand(folder / "logs", folder / "out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  std::string commands = FirstCommands(BytesOfFile(folder / "out" / "report.html"));
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

TEST(BatchBorder, LogsWhoseNamesCannotBeUsedAreNamedAndTheOthersComputed) {
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
  EXPECT_THAT(outcome.output, Not(HasSubstr("will be tried again")));
  EXPECT_GT(fs::file_size(folder / "out/logs/a_a.lcm"), 1000U);
  EXPECT_THAT(BytesOfFile(folder / "out" / "report.html"), HasSubstr("b\\xe4.lcm"));
  const Outcome status = RunProgramOf({"sprout-batch", "status", folder / "out"});
  EXPECT_EQ(status.exit_code, 1);
  EXPECT_THAT(status.output, HasSubstr("c\\x0ad.lcm"));
  const Outcome prefix = RunProgramOf(
      {"sprout-batch", "run", folder / "logs", "--out", folder / "o2", "--channel-prefix", "x'y"});
  EXPECT_EQ(prefix.exit_code, 2);
  EXPECT_THAT(prefix.output, HasSubstr("--channel-prefix 'x'y': allowed are up to"));
}

// One log, computed.
class DamagedBatch : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directory(folder_ / "logs");
    WriteStraddlingLog(folder_ / "logs/run.lcm", "320x240", 0, 8);
    const Outcome outcome = RunProgramOf(Command());
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    answers_ = BytesOfFile(Answers());
    const batch::Manifest manifest = batch::ReadManifest(out_ / "manifest.textproto");
    result_ = batch::BatchFolder(out_).result(manifest, 0, 0);
  }

  std::vector<std::string> Command() const { return RunCommand(folder_ / "logs", out_); }
  fs::path Answers() const { return out_ / "logs" / "run_a.lcm"; }

  TemporaryDirectory folder_;
  fs::path out_ = folder_ / "out";
  fs::path result_;
  std::string answers_;  // bytes of its answers
};

TEST_F(DamagedBatch, AResultThatWasCutIsComputedAgain) {
  const fs::path log = result_ / kAnswers;
  fs::resize_file(log, fs::file_size(log) / 2);
  fs::remove_all(out_ / "logs");
  const Outcome again = RunProgramOf(Command());
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_THAT(again.output, HasSubstr("1 logs, 1 of them to do"));
  EXPECT_TRUE(BytesOfFile(Answers()) == answers_);
}

TEST_F(DamagedBatch, AFlippedBitIsFoundBeforeItIsLinked) {
  std::string bytes = BytesOfFile(result_ / kAnswers);
  bytes[bytes.size() - 100] ^= 4;
  std::ofstream(result_ / kAnswers, std::ios::binary) << bytes;
  fs::remove_all(out_ / "logs");
  const Outcome again = RunProgramOf(Command());
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_THAT(again.output, HasSubstr("damaged; log 0 is computed again"));
  EXPECT_TRUE(BytesOfFile(Answers()) == answers_);
}

TEST_F(DamagedBatch, AManifestFromElsewhereWritesNothingOutside) {
  std::string manifest = BytesOfFile(out_ / "manifest.textproto");
  ReplaceAll(manifest, "name: \"run\"", "name: \"../../victim\"");
  std::ofstream(out_ / "manifest.textproto") << manifest;
  std::ofstream(folder_ / "victim_a.lcm") << "mine";
  for (const std::string command : {"finish", "report", "status"}) {
    const Outcome outcome = RunProgramOf({"sprout-batch", command, out_});
    EXPECT_EQ(outcome.exit_code, 2) << command;
    EXPECT_THAT(outcome.output,
                HasSubstr("manifest.textproto: the manifest cannot be used (name = '../../victim': "
                          "allowed is a file name"));
  }
  EXPECT_EQ(BytesOfFile(folder_ / "victim_a.lcm"), "mine");
}

}  // namespace
}  // namespace sprout
