#include "services/tools/log/program.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>
#include <random>

#include "tests/services/tools/log/graph_log.h"

namespace sprout::log {
namespace {

using testing::HasSubstr;

TEST(LogProgram, ExplainsItselfAndItsCommands) {
  EXPECT_THAT(RunLog({"--help"}).out, HasSubstr("Examples"));
  for (const char* command : {"info", "diff", "cut", "merge", "repair", "images", "export"}) {
    EXPECT_THAT(OutOf({command, "--help"}), HasSubstr(command)) << command;
  }
  EXPECT_THAT(RunLog({"--version"}).out, HasSubstr("sprout-log "));
}

TEST(LogProgram, NoticesAFullDiskBehindStdout) {
  const LogFolder folder;
  const auto log = folder.Write("log", GraphEvents(3));
  const char* const argv[] = {"sprout-log", "info", log.c_str()};
  std::fflush(stdout);
  const int kept = dup(STDOUT_FILENO);
  const int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
  dup2(full, STDOUT_FILENO);
  testing::internal::CaptureStderr();
  const int exit_code = LogMain(3, argv);
  const std::string err = testing::internal::GetCapturedStderr();
  dup2(kept, STDOUT_FILENO);
  std::cout.clear();
  close(kept);
  close(full);
  EXPECT_EQ(exit_code, 2) << "1 says that logs differ";
  EXPECT_EQ(err, "sprout-log: cannot write to stdout\n");
}

TEST(LogProgram, RefusesBadFlagsAndFiles) {
  const LogFolder folder;
  WriteBytes(folder.File("text"), Bytes(1000, 'x'));
  ExpectRefused({}, "which command?");
  ExpectRefused({"inform"}, "did you mean info?");
  ExpectRefused({"info"}, "FILE");
  ExpectRefused({"info", folder.File("none")}, "No such file");
  // As in a folder without permission, not even the type of the file can be found out.
  ExpectRefused({"info", folder.File(std::string(300, 'x').c_str())},
                "cannot be opened (File name too long)");
  ExpectRefused({"info", folder.File("text")}, "not an LCM log");
  ExpectRefused({"repair", folder.File("text"), folder.File("out")}, "not an LCM log");
  EXPECT_EQ(folder.CountEntries(), 1);
}

// Exit code 1 would say that something is wrong with the log.
TEST(LogProgram, RefusesAPlaceThatCannotBeWritten) {
  const LogFolder folder;
  const auto log = folder.Write("log", GraphEvents(1));
  std::filesystem::create_directories(folder.File("out/000000_left.png"));
  ExpectRefused({"images", log, folder.File("out")}, "cannot write ");
}

// Payloads are hit most: what cannot be decoded must not end a command.
TEST(LogProgram, SurvivesAnyDamage) {
  const LogFolder folder;
  auto events = GraphEvents(6);
  const Bytes good = MakeLog(events);
  const auto whole = folder.Write("whole", events);
  for (unsigned seed = 0; seed < 100; ++seed) {
    Bytes bytes = good;
    std::mt19937 random(seed);
    for (int i = 0; i < 20; ++i) bytes[random() % bytes.size()] = static_cast<uint8_t>(random());
    WriteBytes(folder.File("log"), bytes);
    EXPECT_EQ(RunLog({"info", folder.File("log")}).exit_code, 0) << seed;
    EXPECT_EQ(RunLog({"diff", whole, folder.File("log")}).exit_code, 1) << seed;
    EXPECT_EQ(RunLog({"repair", folder.File("log"), folder.File("out"), "--force"}).exit_code, 0);
    EXPECT_THAT(ReadLog(folder.File("out")).damage, testing::IsEmpty()) << seed;
    EXPECT_LE(RunLog({"images", folder.File("log"), folder.File("pictures")}).exit_code, 0) << seed;
  }
}

}  // namespace
}  // namespace sprout::log
