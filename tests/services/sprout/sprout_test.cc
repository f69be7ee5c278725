#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/app/process.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kBin = SPROUT_BINARY_DIR;

struct Ended {
  int exit_code;
  std::string output;
};

Ended RunToEnd(const std::string& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), (kBin / program).string());
  Process process(arguments);
  const int exit_code = process.Wait().value_or(-1);
  return {exit_code, process.Output()};
}

TEST(SproutProgram, ListsEveryProgramThatIsBuiltWithALineEach) {
  const Ended ended = RunToEnd("sprout", {});
  EXPECT_EQ(ended.exit_code, 0);
  int programs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kBin)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("sprout-")) continue;
    EXPECT_THAT(ended.output, HasSubstr("\n  " + name.substr(7) + " ")) << name;
    ++programs;
  }
  EXPECT_GT(programs, 0);
  EXPECT_THAT(ended.output, ::testing::Not(HasSubstr("\n                                ")))
      << "a program has more than one line";
  EXPECT_EQ(RunToEnd("sprout", {"--help"}).output, ended.output);
}

TEST(SproutProgram, RunsTheProgramWithItsArgumentsAndExitCode) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"--help"}, {"info", "no_such.lcm"}, {"info", "--help"}, {}}) {
    std::vector<std::string> with_name = arguments;
    with_name.insert(with_name.begin(), "log");
    const Ended through = RunToEnd("sprout", with_name);
    const Ended direct = RunToEnd("sprout-log", arguments);
    EXPECT_EQ(through.exit_code, direct.exit_code);
    EXPECT_EQ(through.output, direct.output);
  }
}

TEST(SproutProgram, SaysWhatWasMeantByANameThatIsNone) {
  const Ended ended = RunToEnd("sprout", {"lgo", "info"});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_EQ(
      ended.output,
      "sprout: 'lgo' is no command of sprout: did you mean log? (--help lists the commands)\n");
}

}  // namespace
}  // namespace sprout
