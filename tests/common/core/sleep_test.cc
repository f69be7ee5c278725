#include "common/core/sleep.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>

namespace sprout {
namespace {

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
