#include "common/app/process.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <iterator>
#include <stdexcept>

namespace sprout {
namespace {

TEST(Process, TellsHowItEndedAndWhatItWrote) {
  Process process({"sh", "-c", "echo out; echo err >&2; exit 3"});
  EXPECT_EQ(process.Wait(), 3);
  EXPECT_EQ(process.Output(), "out\nerr\n");
  Process killed({"sleep", "1000"});
  killed.Signal(SIGTERM);
  EXPECT_EQ(killed.Wait(), 128 + SIGTERM);
  EXPECT_EQ(Process({"/nonexistent"}).Wait(), 127);
}

TEST(Process, LeavesNothingOpenWhereItCannotBeStarted) {
  const auto count_open = [] {
    const std::filesystem::directory_iterator open("/proc/self/fd");
    return std::distance(begin(open), end(open));
  };
  const auto before = count_open();
  const int free = dup(STDIN_FILENO);  // the smallest number
  close(free);
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const rlimit for_one_pipe{.rlim_cur = static_cast<rlim_t>(free) + 3, .rlim_max = limit.rlim_max};
  setrlimit(RLIMIT_NOFILE, &for_one_pipe);
  EXPECT_THROW(Process({"true"}), std::runtime_error);
  setrlimit(RLIMIT_NOFILE, &limit);
  EXPECT_EQ(count_open(), before);
}

TEST(Process, KeepsTheEndOfALongOutput) {
  Process process({"sh", "-c", "yes | head -c 20000000; echo end"});
  EXPECT_EQ(process.Wait(), 0);
  const std::string output = process.Output();
  EXPECT_LE(output.size(), Process::kOutputBytes);
  EXPECT_TRUE(output.ends_with("y\nend\n"));
}

TEST(Process, GoesOnWhenItsOutputIsEndless) {
  Process process({"yes"});
  EXPECT_EQ(process.Wait(std::chrono::seconds(1)), std::nullopt);
  EXPECT_LE(process.Output().size(), Process::kOutputBytes);
}

}  // namespace
}  // namespace sprout
