#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/system/check_verdict.h"

namespace sprout {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Verdict CheckCapture(const std::vector<std::string>& command) {
  return Check({"--timeout", "1", "--start-timeout", "5", "capture"}, command);
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

struct CaptureFault {
  std::string name;
  std::string line;  // the only one that begins with WRONG, or its beginning
};

void PrintTo(const CaptureFault& fault, std::ostream* out) { *out << fault.name; }

class CheckCaptureFaults : public testing::TestWithParam<CaptureFault> {};

TEST_P(CheckCaptureFaults, AreFoundForTheRightReason) {
  const Verdict verdict = CheckCapture({ProgramPath("wrong_capture"), GetParam().name});
  EXPECT_EQ(verdict.exit_code, 1) << verdict.output;
  EXPECT_THAT(verdict.wrong, ElementsAre(HasSubstr(GetParam().line))) << verdict.output;
}

// What the course of a check finds, and one fault of the messages; capture_listener_test.cc has the
// rest.
INSTANTIATE_TEST_SUITE_P(
    System, CheckCaptureFaults,
    testing::Values(
        CaptureFault{"silent", "sends frames: no whole frame within 5 s; heard on "},
        CaptureFault{"no_tof", ": SPROUT_LEFT, SPROUT_RIG, SPROUT_RIGHT"},
        CaptureFault{
            "ends_at_once",
            "sends frames: before the first whole frame: the program ended with exit code 3"},
        CaptureFault{"stops", "of every frame, once: no whole frame for 1 s after 5 of them"},
        CaptureFault{"rig_once", "and again: no SPROUT_RIG for 3."},
        CaptureFault{
            "ends_early",
            "on SIGTERM: before it was told to, after 5 frames: the program ended with exit"},
        CaptureFault{"ignores_sigterm", "on SIGTERM: still there after 5 s"}),
    [](const auto& test) { return test.param.name; });

TEST(CheckCaptureSystem, PassesTheProgramWithoutAFault) {
  const Verdict verdict = CheckCapture({ProgramPath("wrong_capture"), "none"});
  EXPECT_EQ(verdict.exit_code, 0) << verdict.output;
  EXPECT_THAT(verdict.wrong, IsEmpty());
}

TEST(CheckCaptureSystem, WhatCannotBeStartedIsNoVerdict) {
  EXPECT_EQ(CheckCapture({"/nonexistent"}).exit_code, 2);
}

}  // namespace
}  // namespace sprout
