#include "services/record/log_folder.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <limits>

#include "common/config/config.h"
#include "tests/common/testing/test_with_folder.h"
#include "tests/services/record/make_event.h"

namespace sprout::record {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int64_t kPlenty = 1'000'000'000;

RecordedEvent LastEvent() { return MakeRecorded(99, 10, "STATUS"); }

std::vector<fs::path> Logs(const fs::path& folder) {
  std::vector<fs::path> logs;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (RecordingNumber(entry.path())) logs.push_back(entry.path());
  }
  std::ranges::sort(logs);
  return logs;
}

std::string FailureOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const LogError& error) {
    return error.what();
  } catch (const ConfigError& error) {
    return std::string("flag: ") + error.what();
  }
  return "";
}

class LogFolderTest : public TestWithFolder {};

TEST_F(LogFolderTest, NamesItsLogs) {
  EXPECT_EQ(RecordingNumber("/a/record_000012_20260101_000000Z.lcm"), 12);
  EXPECT_EQ(RecordingNumber("record_1000000_20260101_000000Z.lcm"), 1'000'000);
  for (const char* name : {"record_.lcm", "record_12.lcm", "record_-1_a.lcm", "run_000001_a.lcm",
                           "record_000001_a.lcm.part", "record_99999999999999999999_a.lcm"}) {
    EXPECT_EQ(RecordingNumber(name), std::nullopt) << name;
  }
}

TEST_F(LogFolderTest, BeginsTheNextLogWhenOneIsFull) {
  LogFolder logs({.folder = folder_ / "new/logs", .max_file_bytes = 1000, .quota_bytes = kPlenty},
                 LastEvent);
  for (int i = 0; i < 7; ++i) logs.Write(MakeRecorded(i, 300));  // three fit
  logs.Close();
  const std::vector<fs::path> paths = Logs(folder_ / "new/logs");
  ASSERT_EQ(paths.size(), 3U);
  EXPECT_EQ(paths[0].filename(), "record_000001_19700101_000000Z.lcm");
  EXPECT_EQ(paths[1].filename(), "record_000002_19700101_000003Z.lcm");
  EXPECT_THAT(ReadLog(paths[0]).seconds, ElementsAre(0, 1, 2, 99));
  EXPECT_THAT(ReadLog(paths[0]).channels, ElementsAre("A", "A", "A", "STATUS"));
  EXPECT_THAT(ReadLog(paths[2]).seconds, ElementsAre(6, 99));
  EXPECT_EQ(logs.files(), 3);
  EXPECT_EQ(logs.events(), 10);
}

TEST_F(LogFolderTest, CanBeReadWhileItGrows) {
  LogFolder logs({.folder = folder_ / "", .max_file_bytes = kPlenty, .quota_bytes = kPlenty},
                 LastEvent);
  logs.Write(MakeRecorded(1));
  EXPECT_THAT(ReadLog(logs.path()).seconds, ElementsAre(1));
}

TEST_F(LogFolderTest, CountsOnAndDeletesBesideTheLargestNumberThatThereIs) {
  std::ofstream(folder_ / "record_000041_20990101_000000Z.lcm") << std::string(300, 'x');
  std::ofstream(folder_ / "record_9223372036854775807_x.lcm") << std::string(300, 'x');
  LogFolder logs(
      {.folder = folder_ / "", .max_file_bytes = 500, .quota_bytes = 2000, .delete_oldest = true},
      LastEvent);
  std::vector<int64_t> written;
  for (int i = 0; i < 8; ++i) {
    logs.Write(MakeRecorded(i, 400));
    written.push_back(*RecordingNumber(logs.path()));
  }
  logs.Close();
  EXPECT_THAT(written, ElementsAre(42, 43, 44, 45, 46, 47, 48, 49));
  std::vector<int64_t> left;
  for (const fs::path& log : Logs(folder_ / "")) left.push_back(*RecordingNumber(log));
  EXPECT_THAT(left, ElementsAre(47, 48, 49, std::numeric_limits<int64_t>::max()));
}

TEST_F(LogFolderTest, StopsAtTheQuotaAndDeletesNothing) {
  std::ofstream(folder_ / "notes.txt") << std::string(500, 'x');
  LogFolder logs({.folder = folder_ / "", .max_file_bytes = kPlenty, .quota_bytes = 1500},
                 LastEvent);
  logs.Write(MakeRecorded(1, 400));
  logs.Write(MakeRecorded(2, 400));
  const std::string failure = FailureOf([&] { logs.Write(MakeRecorded(3, 400)); });
  EXPECT_THAT(failure, HasSubstr("its quota is 0.0 MB; nothing was deleted"));
  logs.Close();
  EXPECT_THAT(ReadLog(Logs(folder_ / "")[0]).seconds, ElementsAre(1, 2, 99));
  EXPECT_TRUE(fs::exists(folder_ / "notes.txt"));
}

TEST_F(LogFolderTest, LeavesFoldersThatItMayNotReadOutOfTheQuota) {
  // lost+found of an ext4 disk is such a folder. Root may read everything.
  fs::create_directory(folder_ / "lost+found");
  std::ofstream(folder_ / "lost+found/a") << std::string(5000, 'x');
  fs::permissions(folder_ / "lost+found", fs::perms::none);
  fs::permissions(folder_ / "", fs::perms::all);
  constexpr uid_t kNobody = 65534;
  const bool is_root = geteuid() == 0;
  ASSERT_EQ(is_root ? seteuid(kNobody) : 0, 0);
  const std::string failure = FailureOf([&] {
    LogFolder logs({.folder = folder_ / "", .max_file_bytes = kPlenty, .quota_bytes = 1500},
                   LastEvent);
    logs.Write(MakeRecorded(1, 400));
    logs.Close();
  });
  ASSERT_EQ(is_root ? seteuid(0) : 0, 0);
  fs::permissions(folder_ / "lost+found", fs::perms::all);
  EXPECT_EQ(failure, "");
}

TEST_F(LogFolderTest, DeletesItsOwnOldestOnDemand) {
  std::ofstream(folder_ / "a.lcm") << std::string(500, 'x');
  std::ofstream(folder_ / "record_000007_20990101_000000Z.lcm") << std::string(500, 'x');
  LogFolder logs(
      {.folder = folder_ / "", .max_file_bytes = 500, .quota_bytes = 2000, .delete_oldest = true},
      LastEvent);
  for (int i = 0; i < 5; ++i) logs.Write(MakeRecorded(i, 400));
  logs.Close();
  std::vector<int64_t> numbers;
  for (const fs::path& log : Logs(folder_ / "")) numbers.push_back(*RecordingNumber(log));
  EXPECT_THAT(numbers, ElementsAre(10, 11, 12));
  EXPECT_EQ(logs.deleted(), 3);
  EXPECT_TRUE(fs::exists(folder_ / "a.lcm"));
}

TEST_F(LogFolderTest, NeverDeletesTheLogThatItWrites) {
  LogFolder logs({.folder = folder_ / "",
                  .max_file_bytes = kPlenty,
                  .quota_bytes = 1000,
                  .delete_oldest = true},
                 LastEvent);
  logs.Write(MakeRecorded(1, 800));
  EXPECT_THAT(FailureOf([&] { logs.Write(MakeRecorded(2, 800)); }),
              HasSubstr("no older recording is left to delete"));
}

TEST_F(LogFolderTest, BelongsToOneProcess) {
  const LogFolderOptions options{
      .folder = folder_ / "", .max_file_bytes = kPlenty, .quota_bytes = kPlenty};
  {
    const LogFolder first(options, LastEvent);
    EXPECT_THAT(FailureOf([&] { LogFolder(options, LastEvent); }),
                testing::AllOf(testing::StartsWith("flag: --dir "),
                               HasSubstr("another process records there; allowed")));
  }
  EXPECT_EQ(FailureOf([&] { LogFolder(options, LastEvent); }), "");
}

TEST_F(LogFolderTest, NoticesThatItHasVanished) {
  LogFolder logs({.folder = folder_ / "logs", .max_file_bytes = kPlenty, .quota_bytes = kPlenty},
                 LastEvent);
  logs.Write(MakeRecorded(1));
  logs.RequireThere();
  fs::rename(logs.path(), folder_ / "elsewhere.lcm");
  EXPECT_THAT(FailureOf([&] { logs.RequireThere(); }), HasSubstr(".lcm: has vanished"));
  fs::remove_all(folder_ / "logs");
  EXPECT_THAT(FailureOf([&] { logs.RequireThere(); }), HasSubstr("logs: has vanished"));
}

TEST_F(LogFolderTest, RefusesWhatIsNoFolder) {
  std::ofstream(folder_ / "file");
  EXPECT_THAT(FailureOf([&] {
                LogFolder({.folder = folder_ / "file", .quota_bytes = kPlenty}, LastEvent);
              }),
              HasSubstr("file: cannot be used (Not a directory); allowed: "));
}

}  // namespace
}  // namespace sprout::record
