#include "common/core/output_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iostream>

#include "common/core/input_files.h"
#include "tests/common/testing/test_with_folder.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string WriteAndCommit(const fs::path& path, const std::string& text) {
  OutputFile file(path);
  file.Write(text);
  return WhyNot(file.Commit());
}

class OutputFileTest : public TestWithFolder {};

TEST_F(OutputFileTest, ReplacesARegularFileWhenItIsWhole) {
  std::ofstream(folder_ / "a") << "older";
  OutputFile file(folder_ / "a");
  EXPECT_TRUE(file.replaces());
  file.Write("new");
  EXPECT_EQ(FileText(folder_ / "a"), "older");
  ASSERT_TRUE(file.Commit());
  EXPECT_EQ(FileText(folder_ / "a"), "new");
  EXPECT_EQ(folder_.CountEntries(), 1);
}

TEST_F(OutputFileTest, LeavesNothingWhenItsProcessIsKilled) {
  if (open((folder_ / "").c_str(), O_TMPFILE | O_WRONLY, 0600) < 0) GTEST_SKIP() << "no O_TMPFILE";
  const pid_t child = fork();
  if (child == 0) {
    OutputFile file(folder_ / "a");
    file.Write(std::string(3 << 20, 'x'));
    raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(folder_.CountEntries(), 0);
}

TEST_F(OutputFileTest, HasTheRightsOfAnyNewFile) {
  std::ofstream(folder_ / "plain") << "text";
  EXPECT_EQ(WriteAndCommit(folder_ / "a", "text"), "");
  EXPECT_EQ(fs::status(folder_ / "a").permissions(), fs::status(folder_ / "plain").permissions());
}

TEST_F(OutputFileTest, LeavesWhatTheProgramReads) {
  std::ofstream(folder_ / "read") << "older";
  const InputFileGuard guard;
  NoteInputFile(folder_ / "read");
  const fs::path other_way = folder_ / "below/../read";
  fs::create_directory(folder_ / "below");
  EXPECT_THAT(WriteAndCommit(folder_ / "read", "new"), HasSubstr("an input of this run"));
  EXPECT_THAT(WriteAndCommit(other_way, "new"), HasSubstr("an input of this run"));
  EXPECT_EQ(FileText(folder_ / "read"), "older");
  EXPECT_EQ(WriteAndCommit(folder_ / "beside", "new"), "");
  OutputFile in_place(folder_ / "read", OutputFile::OverInput::kAllowed);
  in_place.Write("new");
  EXPECT_TRUE(in_place.Commit());
  EXPECT_EQ(FileText(folder_ / "read"), "new");
}

TEST_F(OutputFileTest, ReplacesWhatAnEarlierProgramOfTheProcessHasRead) {
  std::ofstream(folder_ / "read") << "older";
  {
    const InputFileGuard guard;
    NoteInputFile(folder_ / "read");
  }
  EXPECT_EQ(WriteAndCommit(folder_ / "read", "new"), "");
}

TEST_F(OutputFileTest, RefusesWhatBecameAnInputMeanwhile) {
  std::ofstream(folder_ / "read") << "older";
  const InputFileGuard guard;
  OutputFile file(folder_ / "read");
  NoteInputFile(folder_ / "read");
  EXPECT_FALSE(file.Commit());
  EXPECT_EQ(FileText(folder_ / "read"), "older");
  EXPECT_EQ(folder_.CountEntries(), 1);
}

TEST_F(OutputFileTest, LeavesNothingWithoutCommit) {
  {
    OutputFile file(folder_ / "a");
    EXPECT_FALSE(file.replaces());
    file.Write("new");
  }
  EXPECT_EQ(folder_.CountEntries(), 0);
}

TEST_F(OutputFileTest, CarriesMoreThanItsBuffer) {
  const std::string large(3 << 20, 'x');
  OutputFile file(folder_ / "a");
  std::string expected;
  for (const std::string& piece : {std::string("ab"), large, std::string("cd"), large}) {
    file.Write(piece);
    expected += piece;
  }
  ASSERT_TRUE(file.Commit());
  EXPECT_EQ(FileText(folder_ / "a") == expected, true);
}

TEST_F(OutputFileTest, TouchesNobodyElsesPart) {
  std::ofstream(folder_ / "a.part") << "mine";
  fs::create_symlink("nowhere", folder_ / "a.part2");
  EXPECT_EQ(WriteAndCommit(folder_ / "a", "new"), "");
  EXPECT_EQ(FileText(folder_ / "a"), "new");
  EXPECT_EQ(FileText(folder_ / "a.part"), "mine");
  EXPECT_TRUE(fs::is_symlink(folder_ / "a.part2"));
  EXPECT_EQ(folder_.CountEntries(), 3);
}

TEST_F(OutputFileTest, OfTwoWritersOfOneNameTheLastOneWins) {
  OutputFile first(folder_ / "a");
  OutputFile second(folder_ / "a");
  first.Write("first");
  second.Write("second");
  EXPECT_TRUE(second.Commit());
  EXPECT_TRUE(first.Commit());
  EXPECT_EQ(FileText(folder_ / "a"), "first");
  EXPECT_EQ(folder_.CountEntries(), 1);
}

TEST_F(OutputFileTest, RefusesWhatIsNoRegularFile) {
  std::ofstream(folder_ / "file") << "kept";
  fs::create_symlink("file", folder_ / "link");
  fs::create_symlink("loop", folder_ / "loop");
  fs::create_directory(folder_ / "folder");
  ASSERT_EQ(mkfifo((folder_ / "fifo").c_str(), 0600), 0);
  const std::string allowed = "; allowed: a new name, a regular file, /dev/stdout or /dev/null";
  for (const auto& [name, reason] : {std::pair{"link", "a symbolic link"},
                                     {"loop", "a symbolic link"},
                                     {"folder", "a folder"},
                                     {"fifo", "a FIFO"}}) {
    EXPECT_EQ(OutputFile(folder_ / name).failure(), reason + allowed);
    EXPECT_EQ(WriteAndCommit(folder_ / name, "new"),
              "cannot write " + (folder_ / name).string() + ": " + reason + allowed);
  }
  EXPECT_EQ(FileText(folder_ / "link"), "kept");
  EXPECT_TRUE(fs::is_fifo(folder_ / "fifo"));
  EXPECT_EQ(folder_.CountEntries(), 5);
}

TEST_F(OutputFileTest, RefusesWhatCameMeanwhile) {
  OutputFile file(folder_ / "a");
  ASSERT_EQ(mkfifo((folder_ / "a").c_str(), 0600), 0);
  EXPECT_THAT(file.Commit().error().text, HasSubstr("a FIFO"));
  EXPECT_TRUE(fs::is_fifo(folder_ / "a"));
  EXPECT_EQ(folder_.CountEntries(), 1);
}

TEST_F(OutputFileTest, RefusesANameThatIsNone) {
  EXPECT_EQ(OutputFile("").failure(), "it names no file");
  EXPECT_EQ(OutputFile(folder_ / "").failure(), "it names no file");
  EXPECT_EQ(OutputFile(folder_ / "missing/a").failure(), "No such file or directory");
}

TEST_F(OutputFileTest, WritesThroughToDevices) {
  EXPECT_EQ(WriteAndCommit("/dev/null", "gone"), "");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_FALSE(fs::exists("/dev/null.part"));
  EXPECT_EQ(WriteAndCommit("/dev/full", "too much"),
            "cannot write /dev/full: No space left on device");
}

TEST_F(OutputFileTest, WritesThroughToStdoutInOrder) {
  testing::internal::CaptureStdout();
  std::cout << "before " << std::flush;
  EXPECT_EQ(WriteAndCommit("/dev/stdout", "between "), "");
  std::cout << "behind" << std::flush;
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "before between behind");
}

TEST_F(OutputFileTest, WritesThroughToAnOpenDescriptor) {
  int ends[2] = {-1, -1};
  ASSERT_EQ(pipe(ends), 0);
  EXPECT_EQ(WriteAndCommit("/dev/fd/" + std::to_string(ends[1]), "hello"), "");
  char text[8] = {};
  EXPECT_EQ(read(ends[0], text, sizeof text), 5);
  EXPECT_STREQ(text, "hello");
  close(ends[0]);
  close(ends[1]);
  EXPECT_EQ(OutputFile("/dev/fd/" + std::to_string(ends[1])).failure(), "Bad file descriptor");
}

}  // namespace
}  // namespace sprout
