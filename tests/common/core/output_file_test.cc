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
#include "tests/common/picture/temporary_directory.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string WriteAndCommit(const fs::path& path, const std::string& text) {
  OutputFile file(path);
  file.Write(text);
  const auto written = file.Commit();
  return written ? "" : written.error().text;
}

TEST(OutputFile, ReplacesARegularFileWhenItIsWhole) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "a") << "older";
  OutputFile file(folder / "a");
  EXPECT_TRUE(file.replaces());
  file.Write("new");
  EXPECT_EQ(FileText(folder / "a"), "older");
  ASSERT_TRUE(file.Commit());
  EXPECT_EQ(FileText(folder / "a"), "new");
  EXPECT_EQ(folder.CountEntries(), 1);
}

TEST(OutputFile, LeavesNothingWhenItsProcessIsKilled) {
  const TemporaryDirectory folder;
  if (open((folder / "").c_str(), O_TMPFILE | O_WRONLY, 0600) < 0) GTEST_SKIP() << "no O_TMPFILE";
  const pid_t child = fork();
  if (child == 0) {
    OutputFile file(folder / "a");
    file.Write(std::string(3 << 20, 'x'));
    raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(folder.CountEntries(), 0);
}

TEST(OutputFile, HasTheRightsOfAnyNewFile) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "plain") << "text";
  EXPECT_EQ(WriteAndCommit(folder / "a", "text"), "");
  EXPECT_EQ(fs::status(folder / "a").permissions(), fs::status(folder / "plain").permissions());
}

TEST(OutputFile, LeavesWhatTheProgramReads) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "read") << "older";
  const InputFileGuard guard;
  NoteInputFile(folder / "read");
  const fs::path other_way = folder / "below/../read";
  fs::create_directory(folder / "below");
  EXPECT_THAT(WriteAndCommit(folder / "read", "new"), HasSubstr("an input of this run"));
  EXPECT_THAT(WriteAndCommit(other_way, "new"), HasSubstr("an input of this run"));
  EXPECT_EQ(FileText(folder / "read"), "older");
  EXPECT_EQ(WriteAndCommit(folder / "beside", "new"), "");
  OutputFile in_place(folder / "read", OutputFile::OverInput::kAllowed);
  in_place.Write("new");
  EXPECT_TRUE(in_place.Commit());
  EXPECT_EQ(FileText(folder / "read"), "new");
}

TEST(OutputFile, ReplacesWhatAnEarlierProgramOfTheProcessHasRead) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "read") << "older";
  {
    const InputFileGuard guard;
    NoteInputFile(folder / "read");
  }
  EXPECT_EQ(WriteAndCommit(folder / "read", "new"), "");
}

TEST(OutputFile, RefusesWhatBecameAnInputMeanwhile) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "read") << "older";
  const InputFileGuard guard;
  OutputFile file(folder / "read");
  NoteInputFile(folder / "read");
  EXPECT_FALSE(file.Commit());
  EXPECT_EQ(FileText(folder / "read"), "older");
  EXPECT_EQ(folder.CountEntries(), 1);
}

TEST(OutputFile, LeavesNothingWithoutCommit) {
  const TemporaryDirectory folder;
  {
    OutputFile file(folder / "a");
    EXPECT_FALSE(file.replaces());
    file.Write("new");
  }
  EXPECT_EQ(folder.CountEntries(), 0);
}

TEST(OutputFile, CarriesMoreThanItsBuffer) {
  const TemporaryDirectory folder;
  const std::string large(3 << 20, 'x');
  OutputFile file(folder / "a");
  std::string expected;
  for (const std::string& piece : {std::string("ab"), large, std::string("cd"), large}) {
    file.Write(piece);
    expected += piece;
  }
  ASSERT_TRUE(file.Commit());
  EXPECT_EQ(FileText(folder / "a") == expected, true);
}

TEST(OutputFile, TouchesNobodyElsesPart) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "a.part") << "mine";
  fs::create_symlink("nowhere", folder / "a.part2");
  EXPECT_EQ(WriteAndCommit(folder / "a", "new"), "");
  EXPECT_EQ(FileText(folder / "a"), "new");
  EXPECT_EQ(FileText(folder / "a.part"), "mine");
  EXPECT_TRUE(fs::is_symlink(folder / "a.part2"));
  EXPECT_EQ(folder.CountEntries(), 3);
}

TEST(OutputFile, OfTwoWritersOfOneNameTheLastOneWins) {
  const TemporaryDirectory folder;
  OutputFile first(folder / "a");
  OutputFile second(folder / "a");
  first.Write("first");
  second.Write("second");
  EXPECT_TRUE(second.Commit());
  EXPECT_TRUE(first.Commit());
  EXPECT_EQ(FileText(folder / "a"), "first");
  EXPECT_EQ(folder.CountEntries(), 1);
}

TEST(OutputFile, RefusesWhatIsNoRegularFile) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "file") << "kept";
  fs::create_symlink("file", folder / "link");
  fs::create_symlink("loop", folder / "loop");
  fs::create_directory(folder / "folder");
  ASSERT_EQ(mkfifo((folder / "fifo").c_str(), 0600), 0);
  const std::string allowed = "; allowed: a new name, a regular file, /dev/stdout or /dev/null";
  for (const auto& [name, reason] : {std::pair{"link", "a symbolic link"},
                                     {"loop", "a symbolic link"},
                                     {"folder", "a folder"},
                                     {"fifo", "a FIFO"}}) {
    EXPECT_EQ(OutputFile(folder / name).failure(), reason + allowed);
    EXPECT_EQ(WriteAndCommit(folder / name, "new"),
              "cannot write " + (folder / name).string() + ": " + reason + allowed);
  }
  EXPECT_EQ(FileText(folder / "link"), "kept");
  EXPECT_TRUE(fs::is_fifo(folder / "fifo"));
  EXPECT_EQ(folder.CountEntries(), 5);
}

TEST(OutputFile, RefusesWhatCameMeanwhile) {
  const TemporaryDirectory folder;
  OutputFile file(folder / "a");
  ASSERT_EQ(mkfifo((folder / "a").c_str(), 0600), 0);
  EXPECT_THAT(file.Commit().error().text, HasSubstr("a FIFO"));
  EXPECT_TRUE(fs::is_fifo(folder / "a"));
  EXPECT_EQ(folder.CountEntries(), 1);
}

TEST(OutputFile, RefusesANameThatIsNone) {
  const TemporaryDirectory folder;
  EXPECT_EQ(OutputFile("").failure(), "it names no file");
  EXPECT_EQ(OutputFile(folder / "").failure(), "it names no file");
  EXPECT_EQ(OutputFile(folder / "missing/a").failure(), "No such file or directory");
}

TEST(OutputFile, WritesThroughToDevices) {
  EXPECT_EQ(WriteAndCommit("/dev/null", "gone"), "");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_FALSE(fs::exists("/dev/null.part"));
  EXPECT_EQ(WriteAndCommit("/dev/full", "too much"),
            "cannot write /dev/full: No space left on device");
}

TEST(OutputFile, WritesThroughToStdoutInOrder) {
  testing::internal::CaptureStdout();
  std::cout << "before " << std::flush;
  EXPECT_EQ(WriteAndCommit("/dev/stdout", "between "), "");
  std::cout << "behind" << std::flush;
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "before between behind");
}

TEST(OutputFile, WritesThroughToAnOpenDescriptor) {
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
