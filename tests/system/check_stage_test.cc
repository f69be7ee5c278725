#include <fcntl.h>
#include <gmock/gmock.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <sstream>

#include "tests/common/picture/temporary_directory.h"
#include "tests/system/graph.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// What sprout-check-stage says about a program, on the network that the test runs in.
struct Verdict {
  int exit_code;
  std::vector<std::string> wrong;  // its lines that begin with WRONG
  std::string output;
};

// @param arguments  flags and the name of the stage.
// @param command    the program that is checked.
Verdict Check(const std::vector<std::string>& arguments, const std::vector<std::string>& command) {
  std::vector<std::string> check = {"sprout-check-stage"};
  check.insert(check.end(), arguments.begin(), arguments.end());
  check.push_back("--");
  check.insert(check.end(), command.begin(), command.end());
  const auto [exit_code, output] = RunProgramOf(check);
  Verdict verdict{.exit_code = exit_code, .wrong = {}, .output = output};
  std::istringstream lines(verdict.output);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("WRONG")) verdict.wrong.push_back(line);
  }
  return verdict;
}

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

Verdict CheckCapture(const std::vector<std::string>& command) {
  return Check({"--timeout", "1", "--start-timeout", "5", "capture"}, command);
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

TEST(CheckCaptureSystem, PassesOurCaptureWithAndWithoutATofCamera) {
  const std::string capture = ProgramPath("sprout-capture");
  for (const std::string source :
       {"synthetic:320x240", "synthetic:320x240?tof=sr4000", "synthetic:320x240?tof=none"}) {
    const Verdict verdict = CheckCapture({capture, "--source", source});
    EXPECT_EQ(verdict.exit_code, 0) << source << "\n" << verdict.output;
    EXPECT_THAT(verdict.output, HasSubstr(" a second; by their utime "));
    EXPECT_THAT(verdict.output, testing::Not(HasSubstr("not checked")));
  }
}

struct Fault {
  std::string name;
  std::string line;  // the only one that begins with WRONG, or its beginning
};

void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.name; }

void ExpectFound(const Fault& fault, const Verdict& verdict) {
  EXPECT_EQ(verdict.exit_code, 1) << verdict.output;
  EXPECT_THAT(verdict.wrong, ElementsAre(HasSubstr(fault.line))) << verdict.output;
}

class CheckStageFaults : public testing::TestWithParam<Fault> {};

TEST_P(CheckStageFaults, AreFoundForTheRightReason) {
  ExpectFound(GetParam(), CheckWrongPrior(GetParam().name));
}

INSTANTIATE_TEST_SUITE_P(
    System, CheckStageFaults,
    testing::Values(
        Fault{"drops_a_frame", "one answer a frame: frame"},
        Fault{"answers_twice", "one answer a frame: frame 0: 2 answers"},
        Fault{"changes_seq", "header passed on: an answer with seq = 1"},
        Fault{"changes_utime", "header passed on: frame 0: answered with utime = "},
        Fault{"changes_rig_id", "header passed on: frame 0: answered with rig_id = '"},
        Fault{"half_size", "type, size and encoding: SPROUT_PRIOR, frame 0: a map of 64x48"},
        Fault{"other_type", "type, size and encoding: SPROUT_PRIOR, frame 0: fingerprint"},
        Fault{"out_of_range", "values in range: SPROUT_PRIOR, frame 0: disparity -3 px at (0, 0)"},
        Fault{"empty", "values in range: SPROUT_PRIOR, frame 0: an empty answer"},
        Fault{"stands_still", "values in range: all 5 frames got the same answer"},
        Fault{"remembers", "same frame, same answer: frame"},
        Fault{"silent_if_poor",
              "poor frames answered: frame 0 without any ToF return: no answer on SPROUT_PRIOR"},
        Fault{"crashes_on_bad",
              "bad messages survived: frame 0 after SPROUT_RIG, no bytes: the "
              "program was killed by signal 6"},
        Fault{"hangs_on_bad",
              "bad messages survived: frame 0 after SPROUT_RIG, no bytes: no "
              "answer on SPROUT_PRIOR within 1 s"},
        Fault{"believes_bad", "bad messages survived: SPROUT_SEEDS, "},
        Fault{"ignores_sigterm", "ends on SIGTERM: still there after 5 s"},
        Fault{"ends_early", "the program ended with exit code 0"},
        Fault{"ends_at_once", "starts and answers: frame 0: the program ended with exit code 3"}),
    [](const auto& test) { return test.param.name; });

TEST(CheckStageSystem, LooksAtWhatComesBesideTheAnswers) {
  const auto check = [](const std::string& fault) {
    return CheckStage("grow", {ProgramPath("wrong_stage"), fault},
                      {"--timeout", "1", "--start-timeout", "5"});
  };
  ExpectFound({"", "type, size and encoding: SPROUT_CONFIDENCE, frame 0: an image of 64x48"},
              check("small_confidence"));
  ExpectFound({"", "one answer a frame: SPROUT_CONFIDENCE, frame 0: 2 messages"},
              check("two_confidences"));
  ExpectFound({"", "SPROUT_CONFIDENCE, frame 0: an image of 128x96 with 3 bytes a pixel"},
              check("colour_confidence"));
  EXPECT_THAT(
      CheckStage("grow", {ProgramPath("sprout-grow"), "--config", "paper"}).output,
      HasSubstr("\ngrow: nothing on SPROUT_CONFIDENCE: give sprout-depth depth { confidence: false "
                "}\n"));
}

class CheckCaptureFaults : public testing::TestWithParam<Fault> {};

TEST_P(CheckCaptureFaults, AreFoundForTheRightReason) {
  ExpectFound(GetParam(), CheckCapture({ProgramPath("wrong_capture"), GetParam().name}));
}

// Faults that the steps of a check find, and one of the messages; capture_listener_test.cc has the
// others.
INSTANTIATE_TEST_SUITE_P(
    System, CheckCaptureFaults,
    testing::Values(
        Fault{"silent", "sends frames: no whole frame within 5 s; heard on "},
        Fault{"no_tof", ": SPROUT_LEFT, SPROUT_RIG, SPROUT_RIGHT"},
        Fault{"ends_at_once",
              "sends frames: before the first whole frame: the program ended with exit code 3"},
        Fault{"stops", "of every frame, once: no whole frame for 1 s after 5 of them"},
        Fault{"rig_once", "and again: no SPROUT_RIG for 3."},
        Fault{"ends_early",
              "on SIGTERM: before it was told to, after 5 frames: the program ended with exit"},
        Fault{"ignores_sigterm", "on SIGTERM: still there after 5 s"}),
    [](const auto& test) { return test.param.name; });

TEST(CheckStageSystem, PassesTheProgramsWithoutAFault) {
  for (const Verdict& verdict :
       {CheckWrongPrior("none"), CheckCapture({ProgramPath("wrong_capture"), "none"})}) {
    EXPECT_EQ(verdict.exit_code, 0) << verdict.output;
    EXPECT_THAT(verdict.wrong, testing::IsEmpty());
  }
}

TEST(CheckStageSystem, FindsAnAnswerOnAnotherChannel) {
  const Verdict verdict = CheckWrongPrior("other_channel");
  EXPECT_EQ(verdict.exit_code, 1);
  EXPECT_THAT(verdict.wrong,
              ElementsAre(HasSubstr("no answer on SPROUT_PRIOR within 5 s; does it listen on "),
                          HasSubstr("published on SPROUT_DISPARITY; allowed is SPROUT_PRIOR")));
  ExpectFound(
      {"", "starts and answers: no answer on SPROUT_PRIOR within 5 s; it publishes on MY_PRIOR"},
      CheckWrongPrior("own_channel"));
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
  EXPECT_THAT(verdict.wrong, testing::Contains(HasSubstr("no answer on SPROUT_FUSED within 2 s")));
}

TEST(CheckStageSystem, WhatCannotBeCheckedIsNoVerdict) {
  EXPECT_EQ(CheckStage("depth", {"true"}).exit_code, 2);
  EXPECT_EQ(CheckStage("prior", {"/nonexistent"}).exit_code, 2);
  EXPECT_EQ(CheckCapture({"/nonexistent"}).exit_code, 2);
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
