#include "common/app/program.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <new>
#include <system_error>

#include "common/app/help_text.h"
#include "common/app/output_paths.h"
#include "tests/common/app/run_main.h"

namespace sprout {
namespace {

using ::testing::ExitedWithCode;
using ::testing::HasSubstr;

class ProgramTest : public ::testing::Test {
 protected:
  ProgramTest() {
    flags_.Add("--file", file_, "Of one");
    flags_.Add("--list", list_, "Of several").SplitAtCommas();
    flags_.Add("--channel-prefix", prefix_, "Before each channel");
    Flags& sub = flags_.AddCommand("sub", "With flags of its own");
    sub.Add("--inner", file_, std::string(60, 'a') + " " + std::string(60, 'b'));
    sub.Add("FILE", file_, "Of one");
    sub.Add("COMMAND", list_, "Of another program");
  }

  // 7 is the exit code of a body that ran.
  MainOutcome Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "probe");
    return RunMain(arguments, [&](int argc, const char* const* argv) {
      return RunProgram(flags_, argc, argv, [] { return 7; });
    });
  }

  Flags flags_{"probe", "Probes what every program shares"};
  std::string file_;
  std::vector<std::string> list_;
  std::string prefix_;
};

TEST_F(ProgramTest, RefusesAnEmptyTextInsteadOfTakingItForNoFlag) {
  const struct {
    std::vector<std::string> arguments;
    const char* named;
  } table[] = {{{"--file", ""}, "--file ''"},
               {{"--list", ""}, "--list ''"},
               {{"sub", "--inner", ""}, "--inner ''"},
               {{"sub", ""}, "FILE ''"}};
  for (const auto& [arguments, named] : table) {
    const MainOutcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << named;
    EXPECT_EQ(outcome.err,
              std::string("probe: ") + named + ": allowed is a text that is not empty\n");
  }
}

TEST_F(ProgramTest, TakesAnEmptyPrefixAndWhatAnotherProgramTakes) {
  EXPECT_EQ(Run({"--channel-prefix", ""}).exit_code, 7);
  EXPECT_EQ(Run({"sub", "a", ""}).exit_code, 7);
  EXPECT_EQ(Run({"--file", "x", "--list", "a,b"}).exit_code, 7);
  EXPECT_EQ(Run({}).exit_code, 7);
}

TEST_F(ProgramTest, WrapsItsHelpAndThatOfItsSubcommands) {
  const std::string help = Run({"sub", "--help"}).out;
  EXPECT_THAT(help, HasSubstr("--inner TEXT                " + std::string(60, 'a') + "\n" +
                              std::string(30, ' ') + std::string(60, 'b') + "\n"));
}

TEST(HelpText, BreaksLinesAtSpacesAndCountsCharacters) {
  const std::string long_word(70, 'x');
  EXPECT_EQ(WrapLines("  --flag  Two words\n\nA table   of two\n", 30),
            "  --flag  Two words\n\nA table   of two\n");
  EXPECT_EQ(WrapLines("  --flag  a " + long_word + " " + long_word + "\n", 4),
            "  --flag  a " + long_word + "\n    " + long_word + "\n");
  EXPECT_EQ(WrapLines("    row " + long_word + " " + long_word + "\n", 30),
            "    row " + long_word + "\n    " + long_word + "\n");
  EXPECT_EQ(WrapLines(std::string(130, 'x') + "\n", 30), std::string(130, 'x') + "\n");
  std::string hundred;
  for (int i = 0; i < 50; ++i) hundred += "×ü";
  EXPECT_EQ(WrapLines(hundred + "\n", 30), hundred + "\n");
}

// Ends as a program does whose file is to become larger than allowed.
[[noreturn]] void WriteBeyondTheLimit(const std::string& path) {
  const rlimit limit{.rlim_cur = 100'000, .rlim_max = 100'000};
  setrlimit(RLIMIT_FSIZE, &limit);
  Flags flags("sprout-x", "");
  const char* const argv[] = {"sprout-x"};
  std::_Exit(RunProgram(flags, 1, argv, [&] {
    WriteWhole(path, std::string(200'000, 'x'));
    return 0;
  }));
}

TEST(RunProgram, SaysWhichFileIsTooLarge) {
  const std::string path = testing::TempDir() + "too_large";
  EXPECT_EXIT(WriteBeyondTheLimit(path), ExitedWithCode(1), "too_large: File too large");
  EXPECT_FALSE(std::filesystem::exists(path));
}

// Says on stderr what a failing thread is put down to when a limit is so low.
[[noreturn]] void SayWithLimit(decltype(RLIMIT_AS) which, rlim_t value) {
  const rlimit limit{.rlim_cur = value, .rlim_max = value};
  setrlimit(which, &limit);
  const std::system_error no_thread(
      std::make_error_code(std::errc::resource_unavailable_try_again));
  std::cerr << no_thread.what() << ReachedLimitText(no_thread);
  std::_Exit(0);
}

// Where the system only says that it is unavailable.
TEST(LimitsText, SaysWhichLimitIsReached) {
  rlim_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t bytes = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
  EXPECT_EXIT(
      SayWithLimit(RLIMIT_AS, bytes + (8 << 20)), ExitedWithCode(0),
      "Resource temporarily unavailable: its address space is limited to [0-9]+ MB .ulimit -v.");
  EXPECT_EXIT(SayWithLimit(RLIMIT_NPROC, 77), ExitedWithCode(0),
              "no thread can be started: allowed are 77 of this user");
  EXPECT_EQ(ReachedLimitText(std::bad_alloc()), ": out of memory");
  EXPECT_THAT(ReachedLimitText(std::runtime_error("thread: Resource temporarily unavailable")),
              HasSubstr("no thread can be started"));
  EXPECT_EQ(ReachedLimitText(std::runtime_error("another")), "");
}

}  // namespace
}  // namespace sprout
