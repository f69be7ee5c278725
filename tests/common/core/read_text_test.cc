#include "common/core/read_text.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "tests/common/picture/temporary_directory.h"
#include "tests/common/testing/thrown.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ReadTextTest : public testing::Test {
 protected:
  fs::path Write(const std::string& text) const {
    std::ofstream(folder_ / "text", std::ios::binary) << text;
    return folder_ / "text";
  }

  static std::string ErrorOf(const fs::path& path, size_t max_bytes = kMaxTextBytes) {
    return WhyNot(ReadText(path, max_bytes));
  }

  TemporaryDirectory folder_;
};

TEST_F(ReadTextTest, LeavesOutAByteOrderMark) {
  EXPECT_EQ(ReadText(Write("\xef\xbb\xbf"
                           "a: 1")),
            "a: 1");
  EXPECT_EQ(ReadText(Write("a\xef\xbb\xbf")), "a\xef\xbb\xbf");
  EXPECT_THAT(ErrorOf(Write("\xff\xfe"
                            "a")),
              HasSubstr("UTF-16; save it as UTF-8"));
}

TEST_F(ReadTextTest, RefusesWhatIsPacked) {
  EXPECT_THAT(ErrorOf(Write("\x1f\x8b\x08")), HasSubstr("packed with gzip; unpack it with gunzip"));
}

TEST_F(ReadTextTest, GivesEveryByte) {
  EXPECT_EQ(ReadText(Write("")), "");
  EXPECT_EQ(ReadText(Write("a\r\n\nb")), "a\r\n\nb");
  const std::string bytes("\0\xff", 2);
  EXPECT_EQ(ReadText(Write(bytes)), bytes);
  fs::create_symlink(folder_ / "text", folder_ / "link");
  EXPECT_EQ(ReadText(folder_ / "link"), bytes);
}

TEST_F(ReadTextTest, ReadsUpToItsLimit) {
  const std::string most(kMaxTextBytes, 'x');
  EXPECT_EQ(ReadText(Write(most)), most);
  EXPECT_EQ(ErrorOf(Write(most + "x")), "cannot be read (larger than 1 MiB)");
  EXPECT_EQ(ErrorOf(folder_ / "text", 2 * kMaxTextBytes), "");
}

TEST_F(ReadTextTest, RefusesWhatIsNoRegularFileWithoutWaiting) {
  const fs::path fifo = folder_ / "fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  for (const fs::path& path : {fifo, folder_ / "", fs::path("/dev/zero"), fs::path("/dev/null")}) {
    EXPECT_EQ(ErrorOf(path), "cannot be read (no regular file)") << path;
  }
}

TEST_F(ReadTextTest, NamesTheReasonOfTheSystem) {
  EXPECT_EQ(ErrorOf(folder_ / "none"), "cannot be read (No such file or directory)");
  fs::create_symlink(folder_ / "loop", folder_ / "loop");
  EXPECT_EQ(ErrorOf(folder_ / "loop"), "cannot be read (Too many levels of symbolic links)");
  EXPECT_EQ(WhyClosed(folder_ / "loop"), " (Too many levels of symbolic links)");
  EXPECT_EQ(WhyClosed(folder_ / "loop" / "none"), " (Too many levels of symbolic links)");
  for (const fs::path& path : {folder_ / "none", Write("a"), folder_ / ""}) {
    EXPECT_EQ(WhyClosed(path), "") << path;
  }
  // Regular, of size 0, and no byte of it can be read.
  EXPECT_EQ(ErrorOf("/proc/self/mem"), "cannot be read (Input/output error)");
}

TEST_F(ReadTextTest, ReadsFilesThatClaimToBeEmpty) {
  EXPECT_EQ(fs::file_size("/proc/self/status"), 0U);
  const Result<std::string> status = ReadText("/proc/self/status");
  ASSERT_TRUE(status);
  EXPECT_THAT(*status, HasSubstr("\nPid:\t" + std::to_string(getpid()) + "\n"));
}

}  // namespace
}  // namespace sprout
