#include "services/capture/pace.h"

#include <gtest/gtest.h>

#include <limits>

namespace sprout::capture {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

FrameId At(int64_t utime) { return {.utime = utime, .seq = 0, .rig_id = ""}; }

class PaceTest : public ::testing::Test {
 protected:
  Pace::Clock::time_point start_ = Pace::Clock::now();
};

TEST_F(PaceTest, WaitsForTheRateBeforeTakingAndNotBeforeSending) {
  Pace pace = Pace::AtRate(10);
  pace.Start(start_);
  EXPECT_EQ(pace.DueBeforeTaking(), start_);
  for (int i = 1; i <= 7; ++i) {
    // A little late each time, which does not add up.
    const auto now = pace.DueBeforeTaking() + milliseconds(10);
    pace.Take(now);
    EXPECT_LE(pace.DueBeforeSending(At(5'000'000), now), now);
    EXPECT_EQ(pace.DueBeforeTaking(), start_ + milliseconds(100 * i));
  }
}

TEST_F(PaceTest, DoesNotCatchUpInABurstAfterAStall) {
  Pace pace = Pace::AtRate(10);
  pace.Start(start_);
  pace.Take(start_);
  pace.Take(start_ + seconds(5));
  EXPECT_EQ(pace.DueBeforeTaking(), start_ + seconds(5) + milliseconds(100));

  Pace recorded = Pace::AsRecorded();
  recorded.Start(start_);
  recorded.DueBeforeSending(At(1'000'000), start_);
  EXPECT_EQ(recorded.DueBeforeSending(At(1'100'000), start_ + milliseconds(150)),
            start_ + milliseconds(100))
      << "a little late";
  const auto late = start_ + seconds(5);
  EXPECT_EQ(recorded.DueBeforeSending(At(1'200'000), late), late);
  EXPECT_EQ(recorded.DueBeforeSending(At(1'300'000), late), late + milliseconds(100));
}

TEST_F(PaceTest, NeverWaitsAtRateZero) {
  Pace pace = Pace::AtRate(0);
  pace.Start(start_);
  for (int i = 0; i < 1000; ++i) pace.Take(start_);
  EXPECT_LE(pace.DueBeforeTaking(), start_);
  EXPECT_LE(pace.DueBeforeSending(At(5'000'000), start_), start_);
}

TEST_F(PaceTest, WaitsForYearsAtTheLowestRates) {
  for (const double rate_hz : {1e-10, 1e-300, std::numeric_limits<double>::denorm_min()}) {
    Pace pace = Pace::AtRate(rate_hz);
    pace.Start(start_);
    pace.Take(start_);
    EXPECT_GT(pace.DueBeforeTaking(), start_ + std::chrono::hours(24 * 365)) << rate_hz;
  }
}

TEST_F(PaceTest, KeepsTheRecordedIntervals) {
  Pace pace = Pace::AsRecorded();
  pace.Start(start_);
  EXPECT_EQ(pace.DueBeforeSending(At(1'000'000), start_), start_);
  pace.Take(start_);
  EXPECT_LE(pace.DueBeforeTaking(), start_);
  EXPECT_EQ(pace.DueBeforeSending(At(1'100'000), start_), start_ + milliseconds(100));
  EXPECT_EQ(pace.DueBeforeSending(At(1'350'000), start_ + milliseconds(100)),
            start_ + milliseconds(350));
}

TEST_F(PaceTest, TakesAStepBackAsNoneAndALongPauseAsTenSeconds) {
  Pace pace = Pace::AsRecorded();
  pace.Start(start_);
  const auto due = [&](int64_t utime) { return pace.DueBeforeSending(At(utime), start_); };
  due(1'000'000);
  EXPECT_EQ(due(400'000), start_);
  EXPECT_EQ(due(500'000), start_ + milliseconds(100));
  EXPECT_EQ(due(std::numeric_limits<int64_t>::max()), start_ + milliseconds(100) + seconds(10));
  EXPECT_EQ(due(0), start_ + milliseconds(100) + seconds(10));
}

TEST_F(PaceTest, SaysWhenAFrameComesMoreThanAnIntervalLate) {
  Pace pace = Pace::AtRate(10);
  const Pace::Clock::time_point start{};
  pace.Start(start);
  EXPECT_FALSE(pace.IsLate(start + std::chrono::milliseconds(90)));
  EXPECT_TRUE(pace.IsLate(start + std::chrono::milliseconds(110)));
  pace.Take(start + std::chrono::milliseconds(110));
  EXPECT_FALSE(pace.IsLate(start + std::chrono::milliseconds(300)));
  EXPECT_FALSE(Pace::AtRate(0).IsLate(start + std::chrono::hours(1)));
  EXPECT_FALSE(Pace::AsRecorded().IsLate(start + std::chrono::hours(1)));
}

}  // namespace
}  // namespace sprout::capture
