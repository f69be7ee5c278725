#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>

#include "tests/common/picture/temporary_directory.h"
#include "tests/system/check_verdict.h"

namespace sprout {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Verdict CheckStage(const std::string& stage, const std::vector<std::string>& command,
                   const std::vector<std::string>& flags = {}) {
  std::vector<std::string> arguments = {"--log", kSampleLog};
  arguments.insert(arguments.end(), flags.begin(), flags.end());
  arguments.push_back(stage);
  return Check(arguments, command);
}

Verdict CheckWrongPrior(const std::string& fault) {
  return CheckStage("prior", {ProgramPath("wrong_stage"), fault},
                    {"--timeout", "1", "--start-timeout", "5"});
}

TEST(CheckStageSystem, PassesOurStages) {
  for (const char* config : {"default", "paper"}) {
    for (const std::string stage : {"refine", "prior", "grow", "temporal"}) {
      const Verdict verdict =
          CheckStage(stage, {ProgramPath("sprout-" + stage), "--config", config});
      EXPECT_EQ(verdict.exit_code, 0) << stage << " " << config << "\n" << verdict.output;
      EXPECT_THAT(verdict.output, HasSubstr("ms a frame in the median"));
      EXPECT_THAT(verdict.output, testing::Not(HasSubstr("not checked")));
    }
  }
}

struct StageFault {
  std::string name;
  std::string line;  // the only one that begins with WRONG, or its beginning
};

void PrintTo(const StageFault& fault, std::ostream* out) { *out << fault.name; }

class CheckStageFaults : public testing::TestWithParam<StageFault> {};

TEST_P(CheckStageFaults, AreFoundForTheRightReason) {
  const Verdict verdict = CheckWrongPrior(GetParam().name);
  EXPECT_EQ(verdict.exit_code, 1) << verdict.output;
  EXPECT_THAT(verdict.wrong, ElementsAre(HasSubstr(GetParam().line))) << verdict.output;
}

INSTANTIATE_TEST_SUITE_P(
    System, CheckStageFaults,
    testing::Values(
        StageFault{"drops_a_frame", "one answer a frame: frame"},
        StageFault{"answers_twice", "one answer a frame: frame 0: 2 answers"},
        StageFault{"changes_seq", "header passed on: an answer with seq = 1"},
        StageFault{"changes_utime", "header passed on: frame 0: answered with utime = "},
        StageFault{"changes_rig_id", "header passed on: frame 0: answered with rig_id = '"},
        StageFault{"half_size", "type, size and encoding: SPROUT_PRIOR, frame 0: a map of 64x48"},
        StageFault{"other_type", "type, size and encoding: SPROUT_PRIOR, frame 0: fingerprint"},
        StageFault{"out_of_range",
                   "values in range: SPROUT_PRIOR, frame 0: disparity -3 px at (0, 0)"},
        StageFault{"empty", "values in range: SPROUT_PRIOR, frame 0: an empty answer"},
        StageFault{"remembers", "same frame, same answer: frame"},
        StageFault{
            "silent_if_poor",
            "poor frames answered: frame 0 without any ToF return: no answer on SPROUT_PRIOR"},
        StageFault{"crashes_on_bad",
                   "bad messages survived: frame 0 after SPROUT_RIG, no bytes: the "
                   "program was killed by signal 6"},
        StageFault{"hangs_on_bad",
                   "bad messages survived: frame 0 after SPROUT_RIG, no bytes: no "
                   "answer on SPROUT_PRIOR within 1 s"},
        StageFault{"believes_bad", "bad messages survived: SPROUT_SEEDS, "},
        StageFault{"ignores_sigterm", "ends on SIGTERM: still there after 5 s"},
        StageFault{"ends_early", "the program ended with exit code 0"},
        StageFault{"ends_at_once",
                   "starts and answers: frame 0: the program ended with exit code 3"}),
    [](const auto& test) { return test.param.name; });

TEST(CheckStageSystem, PassesTheProgramWithoutAFault) {
  const Verdict verdict = CheckWrongPrior("none");
  EXPECT_EQ(verdict.exit_code, 0) << verdict.output;
  EXPECT_THAT(verdict.wrong, IsEmpty());
}

TEST(CheckStageSystem, FindsAnAnswerOnAnotherChannel) {
  const Verdict verdict = CheckWrongPrior("other_channel");
  EXPECT_EQ(verdict.exit_code, 1);
  EXPECT_THAT(verdict.wrong,
              ElementsAre(HasSubstr("no answer within 5 s"),
                          HasSubstr("published on SPROUT_DISPARITY; allowed is SPROUT_PRIOR")));
}

TEST(CheckStageSystem, SaysWhyWhenEveryFrameFailsAndDoesNotAskForTheAddress) {
  const Verdict verdict = CheckWrongPrior("fails");
  EXPECT_EQ(verdict.exit_code, 1);
  EXPECT_THAT(verdict.wrong,
              ElementsAre(testing::ContainsRegex(
                  "no answer: all of [0-9]+ frames failed, the newest: frame [0-9]+: failed: no "
                  "licence")));
}

TEST(CheckStageSystem, FindsWhatIsNoTemporalStage) {
  const Verdict verdict = CheckStage("temporal", {ProgramPath("sprout-grow"), "--config", "fast"},
                                     {"--timeout", "1", "--start-timeout", "2"});
  EXPECT_EQ(verdict.exit_code, 1);
  EXPECT_THAT(verdict.wrong, testing::Contains(HasSubstr("no answer within 2 s")));
}

TEST(CheckStageSystem, WhatCannotBeCheckedIsNoVerdict) {
  EXPECT_EQ(CheckStage("depth", {"true"}).exit_code, 2);
  EXPECT_EQ(CheckStage("prior", {"/nonexistent"}).exit_code, 2);
  EXPECT_EQ(CheckStage("prior", {"true"}, {"--log", "/nonexistent"}).exit_code, 2);
}

// A stage that starts a program and waits; both hold a FIFO open.
TEST(CheckStageSystem, LeavesNothingBehindWhenItIsKilled) {
  for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGKILL}) {
    const TemporaryDirectory folder;
    const std::string fifo = folder / "fifo";
    ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
    const int held = open(fifo.c_str(), O_RDONLY | O_NONBLOCK);
    const std::string script = "exec 3>" + fifo + "; sleep 1000 & echo started >&3; wait";
    Process check({"env", "TMPDIR=" + (folder / "").string(), ProgramPath("sprout-check-stage"),
                   "--log", kSampleLog, "prior", "--", "sh", "-c", script});
    pollfd readable{.fd = held, .events = POLLIN, .revents = 0};
    ASSERT_EQ(poll(&readable, 1, 30'000), 1) << check.Output();
    std::array<char, 64> line;
    ASSERT_GT(read(held, line.data(), line.size()), 0);
    check.Signal(signal);
    EXPECT_EQ(check.Wait(), 128 + signal);
    // Its end comes when the last of them is gone.
    ASSERT_EQ(poll(&readable, 1, 30'000), 1);
    EXPECT_EQ(read(held, line.data(), line.size()), 0) << "signal " << signal;
    close(held);
    EXPECT_EQ(folder.CountEntries(), 1) << "more than the FIFO";
  }
}

TEST(CheckStageSystem, KeepsLittleOfAnEndlessOutput) {
  const Verdict verdict =
      CheckStage("prior", {"sh", "-c", "yes | tr -d '\\n'"}, {"--start-timeout", "3"});
  EXPECT_EQ(verdict.exit_code, 1);
  EXPECT_LT(verdict.output.size(), 10'000U);
  EXPECT_THAT(verdict.output, HasSubstr("yyyyyyyy"));
}

}  // namespace
}  // namespace sprout
