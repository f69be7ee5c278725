#include "common/app/process.h"

#include <gmock/gmock.h>

#include <csignal>

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
