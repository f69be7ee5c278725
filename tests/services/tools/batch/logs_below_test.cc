#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "common/config/config.h"
#include "services/tools/batch/log_list.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

std::vector<fs::path> PathsBelow(const fs::path& folder) {
  const std::vector<std::string> logs = LogsBelow(folder);
  return {logs.begin(), logs.end()};
}

TEST(LogsBelow, GivesLogsAndNothingElseSorted) {
  const TemporaryDirectory folder;
  EXPECT_THROW(LogsBelow(folder / ""), ConfigError);
  fs::create_directories(folder / "b/c.lcm");
  for (const char* name : {"z.lcm", "b/a.lcm", "a.lcm.part", "notes.txt", "b/c.lcm/d.lcm"}) {
    std::ofstream(folder / name);
  }
  EXPECT_THAT(PathsBelow(folder / ""),
              ElementsAre(folder / "b/a.lcm", folder / "b/c.lcm/d.lcm", folder / "z.lcm"));
}

TEST(LogsBelow, GivesALogWithSeveralNamesOnce) {
  const TemporaryDirectory folder;
  const TemporaryDirectory elsewhere;
  fs::create_directory(folder / "b");
  std::ofstream(folder / "b/target.lcm") << "x";
  std::ofstream(elsewhere / "far.lcm") << "x";
  std::ofstream(folder / "same_content.lcm") << "x";
  fs::create_symlink(folder / "b/target.lcm", folder / "a_link.lcm");
  fs::create_hard_link(folder / "b/target.lcm", folder / "second_name.lcm");
  fs::create_symlink(elsewhere / "far.lcm", folder / "far_1.lcm");
  fs::create_symlink(elsewhere / "far.lcm", folder / "far_2.lcm");
  fs::create_symlink(folder / "nowhere", folder / "dangling.lcm");
  EXPECT_THAT(PathsBelow(folder / ""), ElementsAre(folder / "b/target.lcm", folder / "far_1.lcm",
                                                   folder / "same_content.lcm"));
}

}  // namespace
}  // namespace sprout::batch
