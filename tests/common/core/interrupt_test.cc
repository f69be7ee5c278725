#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <future>
#include <thread>

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
    std::raise(SIGINT);  // as timeout(1) does
    EXPECT_TRUE(Interrupt::requested());
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
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
  EXPECT_EXIT(watch(SIGHUP), ::testing::ExitedWithCode(0), "");
}

// timeout(1) sends the second one at once.
TEST(SignalWatcherDeathTest, EndsAtTheSecondSignalButNotAtAnEchoOfTheFirst) {
  const auto watch = [](int milliseconds) {
    const SignalWatcher watcher;
    kill(getpid(), SIGTERM);
    SleepFor(std::chrono::seconds(30), watcher.token());
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    kill(getpid(), SIGTERM);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    _exit(0);
  };
  EXPECT_EXIT(watch(0), ::testing::ExitedWithCode(0), "");
  EXPECT_EXIT(watch(1000), ::testing::KilledBySignal(SIGTERM), "");
}

TEST(SignalWatcherDeathTest, OutlivesItsTerminalWhenItIsToldTo) {
  const auto watch = [] {
    std::signal(SIGHUP, SIG_IGN);
    const SignalWatcher watcher;
    kill(getpid(), SIGHUP);
    _exit(SleepFor(std::chrono::milliseconds(100), watcher.token()) ? 0 : 1);
  };
  EXPECT_EXIT(watch(), ::testing::ExitedWithCode(0), "");
}

TEST(SignalWatcherDeathTest, IsNotEndedByTheSecondSignalOfATerminalThatGoes) {
  const auto watch = [] {
    {
      const SignalWatcher watcher;
      kill(getpid(), SIGHUP);
      SleepFor(std::chrono::seconds(30), watcher.token());
      kill(getpid(), SIGHUP);
    }
    _exit(0);
  };
  EXPECT_EXIT(watch(), ::testing::ExitedWithCode(0), "");
}

TEST(SignalWatcherDeathTest, LeavesWhatIsStuckToTheKernelAfterTheGracePeriod) {
  const auto hang = [] {
    const SignalWatcher watcher(std::chrono::milliseconds(50));
    kill(getpid(), SIGTERM);
    while (true) pause();
  };
  EXPECT_EXIT(hang(), ::testing::KilledBySignal(SIGALRM), "");
}

using std::chrono::hours;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

TEST(Sleep, LastsAsLongAsItIsTold) {
  const std::stop_source stop;
  const Clock::time_point begin = Clock::now();
  EXPECT_TRUE(SleepFor(milliseconds(20), stop.get_token()));
  EXPECT_GE(Clock::now() - begin, milliseconds(20));
  EXPECT_TRUE(SleepUntil(begin + milliseconds(40), stop.get_token()));
  EXPECT_GE(Clock::now() - begin, milliseconds(40));
  EXPECT_TRUE(SleepUntil(begin, stop.get_token()));  // over already
}

TEST(Sleep, EndsWithAStop) {
  std::stop_source stop;
  auto sleeper =
      std::async(std::launch::async, [&] { return SleepFor(hours(1), stop.get_token()); });
  EXPECT_EQ(sleeper.wait_for(milliseconds(20)), std::future_status::timeout);
  stop.request_stop();
  ASSERT_EQ(sleeper.wait_for(std::chrono::seconds(30)), std::future_status::ready);
  EXPECT_FALSE(sleeper.get());
  EXPECT_FALSE(SleepFor(hours(1), stop.get_token()));  // nor does another begin
}

}  // namespace

}  // namespace sprout
