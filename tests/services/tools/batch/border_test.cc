// Inputs that anybody may have written: names of logs, lists, results.
#include <gmock/gmock.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "common/app/process.h"
#include "common/config/config.h"
#include "common/logfile/log_error.h"
#include "services/tools/batch/engines.h"
#include "services/tools/batch/frame_table.h"
#include "services/tools/batch/log_task.h"
#include "services/tools/batch/planning.h"
#include "services/tools/batch/report.h"
#include "services/tools/batch/result_folder.h"
#include "tests/common/testing/test_with_folder.h"
#include "tests/common/testing/thrown.h"
#include "tests/services/tools/batch/example_manifest.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

void WriteFile(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

void FlipBit(const fs::path& path) {
  std::string bytes = FileText(path);
  bytes[bytes.size() / 2] ^= 1;
  WriteFile(path, bytes);
}

const std::string kOddNames[] = {"two words",     " leading",
                                 "-dash",         "x'$(touch PWNED)'",
                                 "`touch PWNED`", "$(touch PWNED)",
                                 "${HOME}",       "\"quoted\"",
                                 "it's",          "'; touch PWNED; '",
                                 "back\\slash\\", "a;touch PWNED",
                                 "a&touch PWNED", "a|touch PWNED",
                                 ">PWNED",        "*",
                                 "[a-z]?",        "~",
                                 "#hash",         "!!",
                                 "{a,b}=%s",      "\u00fcmlaut \u6df1\u5ea6"};

TEST(ResultNames, AreUniqueAfterCharactersAreReplaced) {
  std::set<std::string> taken;
  EXPECT_EQ(ResultNameOf("/x/run_1.lcm", taken), "run_1");
  EXPECT_EQ(ResultNameOf("/x/run,1.lcm", taken), "run_1-2");
  EXPECT_EQ(ResultNameOf("/x/run\"1.lcm", taken), "run_1-3");
  EXPECT_EQ(ResultNameOf("/x/run_1-2.lcm", taken), "run_1-2-2");
  EXPECT_EQ(ResultNameOf("/x/...lcm", taken), "log");  // its stem is ".."
  EXPECT_THAT(ResultNameOf("/x/" + std::string(250, 'x') + ".lcm", taken), SizeIs(180));
}

TEST(ResultNames, AreGoodForOddLogs) {
  std::set<std::string> taken;
  for (const std::string& name : kOddNames) {
    EXPECT_TRUE(IsResultName(ResultNameOf("/x/" + name + ".lcm", taken))) << name;
  }
  EXPECT_THAT(taken, SizeIs(std::size(kOddNames)));
}

// Programs that note what they were called with, one argument a line.
void WriteStubs(const fs::path& folder) {
  for (const char* name : {"sprout-view", "sprout-refine", "sprout-prior", "sprout-grow"}) {
    WriteFile(folder / name,
              "#!/bin/sh\nfor word in \"${0##*/}\" \"$@\"; do printf '%s\\n' \"$word\" >> "
              "\"$CALLS\"; done\n");
    fs::permissions(folder / name, fs::perms::owner_all);
  }
}

// What the stubs note when the commands of a frame are run.
std::string CallsOf(const std::string& name) {
  const std::string log = "/logs/" + name + ".lcm";
  const std::string start =
      "\n--config\n/out/" + name + "/config_a.textproto\n--frames\n7\n--replay\n" + log + "\n";
  const std::string prefix = "--channel-prefix=" + name + "\n";
  return "sprout-view\n--log\n" + log + "\n--frame\n7\n" + prefix + "sprout-refine" + start +
         "--record\nrefine_a.lcm\n" + prefix + "sprout-prior" + start +
         "--replay\nrefine_a.lcm\n--record\nprior_a.lcm\n" + prefix;
}

TEST(Slurm, AnArrayWhoseReportIsRefusedIsKnown) {
  const TemporaryDirectory folder;
  WriteFile(folder / "sbatch",
            "#!/bin/sh\ncase \"$*\" in *finish*) printf 'too many\\njobs\\n'; exit 1 ;; esac\n"
            "echo \"$*\" > \"$0.calls\"\necho 7\n");
  WriteFile(folder / "squeue",
            "#!/bin/sh\ncase \"$*\" in *%T*) echo 'RUNNING (None)'; echo 'RUNNING (None)'; "
            "echo 'PENDING (Resources)' ;; *) echo 7_0 ;; esac\n");
  for (const char* name : {"sbatch", "squeue"}) {
    fs::permissions(folder / name, fs::perms::owner_all);
  }
  const std::string path = std::getenv("PATH");
  setenv("PATH", ((folder / "").string() + ":" + path).c_str(), /*overwrite=*/1);
  const BatchFolder out(folder / "50%A");
  const std::string error = Thrown<ConfigError>(
      [&] { SubmitSlurm("sprout-batch", out, {.done = {false}, .missing = 1}, {}, 0); });
  const std::string active = ActiveJobs(out);
  const std::string states = StatesOfJobs(active);
  setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(error, HasSubstr("sbatch: too many; jobs; job 7 computes all the same"));
  EXPECT_EQ(active, "7");
  EXPECT_THAT(FileText(folder / "sbatch.calls"), HasSubstr("/50%%A/slurm/compute_%A_%a.txt "));
  EXPECT_EQ(states, "1 PENDING (Resources), 2 RUNNING");
}

// When the program is missing, say, no failure of a log is noted.
TEST(Slurm, TheTaskThatSaidSomethingLastIsShown) {
  const TemporaryDirectory folder;
  const BatchFolder out(folder / "out");
  EXPECT_EQ(TaskOutput(out), "");
  const fs::path slurm = out.root() / "slurm";
  fs::create_directories(slurm);
  WriteFile(slurm / "compute_7_0.txt", "");
  WriteFile(slurm / "finish_8.txt", "3 frames\n");
  EXPECT_EQ(TaskOutput(out), "");
  WriteFile(slurm / "compute_7_1.txt", "sh: 2: exec: /gone/sprout-batch: not found\n");
  EXPECT_EQ(TaskOutput(out),
            (slurm / "compute_7_1.txt").string() + ": sh: 2: exec: /gone/sprout-batch: not found");
}

TEST(FrameCommands, StandForThemselvesInAShellWhateverIsInTheNames) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "bin");
  std::string commands = "cd '" + (folder / "").string() + "' || exit 9\n";
  std::string calls;
  for (const std::string& name : kOddNames) {
    const fs::path bin = (folder / "bin") / name;
    fs::create_directory(bin);
    WriteStubs(bin);
    Manifest manifest;
    manifest.set_channel_prefix(name);
    Variant& variant = *manifest.add_variant();
    for (const std::string stage : {"refine", "prior"}) {
      manifest.add_stage(stage);
      variant.add_program()->set_path(bin / ("sprout-" + stage));
    }
    BatchLog log;
    log.set_path("/logs/" + name + ".lcm");
    commands += FrameCommands(BatchFolder("/out/" + name), manifest, log, 7, bin);
    calls += CallsOf(name);
  }
  WriteFile(folder / "commands", commands);
  for (const char* const shell : {"sh", "bash"}) {
    Process process({"env", "CALLS=" + (folder / "calls").string(), shell, folder / "commands"});
    EXPECT_EQ(process.Wait(std::chrono::seconds(120)), 0) << process.Output();
    EXPECT_EQ(FileText(folder / "calls"), calls) << shell;
    fs::remove(folder / "calls");
    EXPECT_EQ(folder.CountEntries(), 2);  // bin and commands alone: no name has created PWNED
  }
}

class FoundLogsTest : public TestWithFolder {};

TEST_F(FoundLogsTest, RefusesWhatCannotStandInAManifest) {
  for (const char* name : {"a.lcm", "\u00fc.lcm"}) WriteFile(folder_ / name, "x");
  const std::string path = (folder_ / "").string();
  EXPECT_THAT(FindLogs({folder_ / ""}), ElementsAre(path + "a.lcm", path + "\u00fc.lcm"));
  for (const auto& [name, shown] :
       {std::pair("b\xe4.lcm", "b\\xe4.lcm"), std::pair("c\nd.lcm", "c\\x0ad.lcm")}) {
    WriteFile(folder_ / name, "x");
    EXPECT_THAT(Thrown<ConfigError>([&] { FindLogs({folder_ / ""}); }),
                HasSubstr(std::string(shown) + "': allowed is UTF-8 without control characters"));
    std::filesystem::remove(folder_ / name);
  }
}

TEST_F(FoundLogsTest, RefusesAListThatContainsItself) {
  const std::string list = folder_ / "list.txt";
  WriteFile(folder_ / "a.lcm", "x");
  WriteFile(list, (folder_ / "a.lcm").string() + "\n@" + list + "\n");
  EXPECT_THAT(Thrown<ConfigError>([&] { FindLogs({"@" + list}); }),
              HasSubstr("list.txt: the list contains itself"));
  // Also over another list, and over a link. Twice the same beside each other is none.
  const std::string other = folder_ / "other.txt";
  fs::create_symlink(list, folder_ / "link.txt");
  WriteFile(list, "@" + other + "\n");
  WriteFile(other, "@" + (folder_ / "link.txt").string() + "\n");
  EXPECT_THAT(Thrown<ConfigError>([&] { FindLogs({"@" + list}); }), HasSubstr("contains itself"));
  WriteFile(other, (folder_ / "a.lcm").string() + "\n");
  EXPECT_THAT(FindLogs({"@" + list, "@" + list}), SizeIs(1));
  EXPECT_THAT(Thrown<ConfigError>([&] { FindLogs({"@/dev/zero"}); }), HasSubstr("no such list"));
}

TEST_F(FoundLogsTest, ReadsAListOfWindows) {
  WriteFile(folder_ / "a.lcm", "x");
  const std::string path = folder_ / "a.lcm";
  WriteFile(folder_ / "list.txt", "\xef\xbb\xbf" + path + "\r\n\r\n" + path + "\r\n");
  EXPECT_THAT(FindLogs({"@" + (folder_ / "list.txt").string()}), ElementsAre(path));
}

class AResult : public TestWithFolder {
 protected:
  void SetUp() override {
    ResultFolder result(path_);
    WriteTable(result / "measures.csv",
               {.columns = {"seq", "utime", "left_at"}, .rows = {{1, 2, 3}}});
    WriteFile(result / "grow.lcm", std::string(1000, 'x'));
    result.Commit();
  }

  fs::path path_ = folder_ / "result";
};

TEST_F(AResult, IsWholeAsItWasWritten) {
  EXPECT_TRUE(IsWhole(path_, ResultCheck::kQuick));
  EXPECT_TRUE(IsWhole(path_, ResultCheck::kAll));
  EXPECT_FALSE(IsWhole(folder_ / "none", ResultCheck::kQuick));
  EXPECT_EQ(folder_.CountEntries(), 1);
}

TEST_F(AResult, IsNotWholeWhenAFileIsCutOrGone) {
  fs::resize_file(path_ / "grow.lcm", 500);
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kQuick));
  fs::remove(path_ / "grow.lcm");
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kQuick));
}

TEST_F(AResult, IsNotWholeWhenABitIsFlipped) {
  FlipBit(path_ / "grow.lcm");
  EXPECT_TRUE(IsWhole(path_, ResultCheck::kQuick));  // the bytes of logs are not read
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kAll));
  MarkDamaged(path_);
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kQuick));
}

TEST_F(AResult, IsNotWholeWhenABitOfATableOrOfTheListIsFlipped) {
  FlipBit(path_ / "measures.csv");
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kQuick));
  FlipBit(path_ / "measures.csv");
  EXPECT_TRUE(IsWhole(path_, ResultCheck::kQuick));
  FlipBit(path_ / "files.txt");
  EXPECT_FALSE(IsWhole(path_, ResultCheck::kQuick));
}

TEST_F(AResult, IsReplacedWhenItIsDamagedAndKeptWhenNot) {
  const auto write_again = [&] {
    ResultFolder again(path_);
    WriteFile(again / "grow.lcm", "new");
    again.Commit();
  };
  write_again();
  EXPECT_THAT(FileText(path_ / "grow.lcm"), SizeIs(1000));
  FlipBit(path_ / "grow.lcm");
  write_again();
  EXPECT_EQ(FileText(path_ / "grow.lcm"), "new");
  EXPECT_EQ(folder_.CountEntries(), 1);
}

// A batch with x done; y is not.
class LinkedAnswers : public TestWithFolder {
 protected:
  void SetUp() override {
    manifest_.mutable_variant()->RemoveLast();
    WriteResult();
  }

  void WriteResult() const {
    ResultFolder result(batch_.result(manifest_, 0, 0));
    WriteFile(result / kAnswers, std::string(1000, 'x'));
    result.Commit();
  }

  BatchFolder batch_{folder_ / ""};
  Manifest manifest_ = ExampleManifest();
  fs::path link_ = batch_.answers(manifest_.log(0), 0);
};

TEST_F(LinkedAnswers, AreThoseOfLogsThatAreDone) {
  fs::create_directory(folder_ / "logs");
  fs::create_symlink("../results/ab/abc/answers.lcm", batch_.answers(manifest_.log(1), 0));
  fs::create_symlink("../results/ab/abc/answers.lcm", folder_ / "logs/gone_b.lcm");
  WriteFile(folder_ / "logs/mine.lcm", "a log");
  const BatchState state = LinkAnswers(batch_, manifest_);
  EXPECT_THAT(state.done, ElementsAre(true, false));
  EXPECT_EQ(state.missing, 1);
  EXPECT_THAT(FileText(link_), SizeIs(1000));
  EXPECT_TRUE(fs::read_symlink(link_).is_relative());  // the folder may be moved
  std::set<fs::path> left;
  for (const auto& entry : fs::directory_iterator(folder_ / "logs")) left.insert(entry.path());
  EXPECT_THAT(left, ElementsAre(folder_ / "logs/mine.lcm", link_));
}

// The output folder contains the logs, one of which has the name of a link to answers.
TEST_F(LinkedAnswers, ReplaceNobodysLog) {
  fs::create_directory(folder_ / "logs");
  for (const int log : {0, 1}) {
    const fs::path taken = batch_.answers(manifest_.log(log), 0);
    WriteFile(taken, "a log");
    EXPECT_THAT(Thrown<LogError>([&] { LinkAnswers(batch_, manifest_); }),
                HasSubstr("is where a link to answers belongs; allowed: another --out"));
    EXPECT_EQ(FileText(taken), "a log");
    fs::remove(taken);
  }
}

TEST_F(LinkedAnswers, AreNotThoseWithAFlippedBit) {
  FlipBit(batch_.result(manifest_, 0, 0) / kAnswers);
  EXPECT_EQ(LinkAnswers(batch_, manifest_).missing, 2);
  EXPECT_FALSE(fs::exists(link_));
  EXPECT_EQ(StateOf(batch_, manifest_).missing, 2);  // the quick check knows it now
  WriteResult();
  EXPECT_EQ(LinkAnswers(batch_, manifest_).missing, 1);
  EXPECT_TRUE(fs::exists(link_));
}

TEST(RemoveParts, LeavesWhatIsSomebodyElses) {
  const TemporaryDirectory folder;
  const fs::path part = folder / "results/ab/abababababababab.part-host-7";
  const fs::path mine = folder / "results/maps/map.part-1";
  fs::create_directories(part);
  fs::create_directories(mine);
  WriteFile(folder / "results/notes.txt", "mine");
  RemoveParts(BatchFolder(folder / ""));
  EXPECT_FALSE(fs::exists(part));
  EXPECT_TRUE(fs::exists(mine));
}

TEST(Tables, AreRefusedWhenTheyAreNotOfFrames) {
  const TemporaryDirectory folder;
  const fs::path path = folder / "t.csv";
  const auto error_of = [&](const std::string& text) {
    WriteFile(path, text);
    return Thrown<LogError>([&] { ReadTable(path, {"x"}); });
  };
  EXPECT_EQ(error_of("seq,utime,left_at,x\n1,2,,3\n"), "no error");
  EXPECT_THAT(error_of(""), HasSubstr("t.csv: cannot be read"));
  EXPECT_THAT(error_of("seq\n1\n"), HasSubstr("has other columns"));
  EXPECT_THAT(error_of("seq,utime,left_at,x\n1,2,3\n"), HasSubstr("a row has missing cells"));
  EXPECT_THAT(error_of("seq,utime,left_at,x\n1,,3,4\n"), HasSubstr("a row has no seq or utime"));
  EXPECT_THAT(error_of("seq,utime,left_at,x\n1,2,3,inf\n"), HasSubstr("'inf' is no finite number"));
}

std::vector<fs::path> PathsBelow(const fs::path& folder) {
  const std::vector<std::string> logs = LogsBelow(folder);
  return {logs.begin(), logs.end()};
}

TEST_F(FoundLogsTest, GivesLogsAndNothingElseSorted) {
  EXPECT_THROW(LogsBelow(folder_ / ""), ConfigError);
  fs::create_directories(folder_ / "b/c.lcm");
  for (const char* name : {"z.lcm", "b/a.lcm", "a.lcm.part", "notes.txt", "b/c.lcm/d.lcm"}) {
    std::ofstream(folder_ / name);
  }
  EXPECT_THAT(PathsBelow(folder_ / ""),
              ElementsAre(folder_ / "b/a.lcm", folder_ / "b/c.lcm/d.lcm", folder_ / "z.lcm"));
}

TEST_F(FoundLogsTest, GivesALogWithSeveralNamesOnce) {
  const TemporaryDirectory elsewhere;
  fs::create_directory(folder_ / "b");
  std::ofstream(folder_ / "b/target.lcm") << "x";
  std::ofstream(elsewhere / "far.lcm") << "x";
  std::ofstream(folder_ / "same_content.lcm") << "x";
  fs::create_symlink(folder_ / "b/target.lcm", folder_ / "a_link.lcm");
  fs::create_hard_link(folder_ / "b/target.lcm", folder_ / "second_name.lcm");
  fs::create_symlink(elsewhere / "far.lcm", folder_ / "far_1.lcm");
  fs::create_symlink(elsewhere / "far.lcm", folder_ / "far_2.lcm");
  fs::create_symlink(folder_ / "nowhere", folder_ / "dangling.lcm");
  EXPECT_THAT(PathsBelow(folder_ / ""), ElementsAre(folder_ / "b/target.lcm", folder_ / "far_1.lcm",
                                                    folder_ / "same_content.lcm"));
}

TEST_F(FoundLogsTest, NamesAFolderThatItMayNotRead) {
  fs::create_directory(folder_ / "lost+found");
  fs::permissions(folder_ / "lost+found", fs::perms::none);
  fs::permissions(folder_ / "", fs::perms::all);
  constexpr uid_t kNobody = 65534;
  const bool is_root = geteuid() == 0;
  ASSERT_EQ(is_root ? seteuid(kNobody) : 0, 0);
  const std::string error = Thrown<ConfigError>([&] { LogsBelow(folder_ / ""); });
  ASSERT_EQ(is_root ? seteuid(0) : 0, 0);
  fs::permissions(folder_ / "lost+found", fs::perms::all);
  EXPECT_THAT(error, HasSubstr("lost+found: cannot be read (Permission denied)"));
}

TEST_F(FoundLogsTest, LeavesOutWhatBatchesAnswered) {
  for (const char* path : {"out/results/ab/abc", "out/logs", "results/mon/am"}) {
    fs::create_directories(folder_ / path);
  }
  for (const char* name : {"x.lcm", "results/mon/am/mine.lcm", "out/manifest.textproto",
                           "out/results/ab/abc/answers.lcm"}) {
    std::ofstream(folder_ / name) << name;
  }
  fs::create_symlink("../results/ab/abc/answers.lcm", folder_ / "out/logs/x_a.lcm");
  EXPECT_THAT(PathsBelow(folder_ / ""),
              ElementsAre(folder_ / "results/mon/am/mine.lcm", folder_ / "x.lcm"));
}

}  // namespace
}  // namespace sprout::batch
