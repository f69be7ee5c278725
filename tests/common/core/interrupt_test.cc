#include "common/core/interrupt.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>

#include "common/core/signal_watcher.h"
#include "common/core/sleep.h"

namespace sprout {
namespace {

TEST(Interrupt, TakesNoteOfASignalWhileItLives) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const Interrupt interrupt;
    EXPECT_FALSE(Interrupt::requested());  // the one before is forgotten
    EXPECT_NO_THROW(Interrupt::Check());
    std::raise(signal);
    EXPECT_TRUE(Interrupt::requested());
    EXPECT_THROW(Interrupt::Check(), Interrupted);
  }
}

TEST(InterruptDeathTest, EndsTheProgramAtTheSecondSignalAndAfterItsLife) {
  const auto twice = [] {
    const Interrupt interrupt;
    std::raise(SIGINT);
    std::raise(SIGINT);
  };
  EXPECT_EXIT(twice(), ::testing::KilledBySignal(SIGINT), "");
  const auto after = [] {
    { const Interrupt interrupt; }
    std::raise(SIGTERM);
  };
  EXPECT_EXIT(after(), ::testing::KilledBySignal(SIGTERM), "");
}

// In a process of its own, since the signals stay blocked in whoever had a watcher.
TEST(SignalWatcherDeathTest, RequestsAStopAndTellsWhichSignalItWas) {
  const auto watch = [](int signal) {
    int told = 0;
    {
      const SignalWatcher watcher({}, [&](int number) { told = number; });
      kill(getpid(), signal);
      if (SleepFor(std::chrono::seconds(30), watcher.token())) _exit(1);
    }
    _exit(told == signal ? 0 : 2);
  };
  EXPECT_EXIT(watch(SIGINT), ::testing::ExitedWithCode(0), "");
  EXPECT_EXIT(watch(SIGTERM), ::testing::ExitedWithCode(0), "");
}

TEST(SignalWatcherDeathTest, LeavesWhatIsStuckToTheKernelAfterTheGracePeriod) {
  const auto hang = [] {
    const SignalWatcher watcher(std::chrono::milliseconds(50));
    kill(getpid(), SIGTERM);
    while (true) pause();
  };
  EXPECT_EXIT(hang(), ::testing::KilledBySignal(SIGALRM), "");
}

}  // namespace
}  // namespace sprout
