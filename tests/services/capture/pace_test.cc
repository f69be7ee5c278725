#include "services/capture/pace.h"

#include <gtest/gtest.h>

#include <limits>

namespace sprout {
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
  EXPECT_EQ(pace.DueBeforeTaking(0), start_);
  EXPECT_EQ(pace.DueBeforeTaking(7), start_ + milliseconds(700));
  EXPECT_LE(pace.DueBeforeSending(At(5'000'000)), start_);
  EXPECT_EQ(pace.DueBeforeTaking(8), start_ + milliseconds(800));
}

TEST_F(PaceTest, NeverWaitsAtRateZero) {
  Pace pace = Pace::AtRate(0);
  pace.Start(start_);
  EXPECT_LE(pace.DueBeforeTaking(1'000'000), start_);
  EXPECT_LE(pace.DueBeforeSending(At(5'000'000)), start_);
}

TEST_F(PaceTest, KeepsTheRecordedIntervals) {
  Pace pace = Pace::AsRecorded();
  pace.Start(start_);
  EXPECT_EQ(pace.DueBeforeSending(At(1'000'000)), start_);
  EXPECT_LE(pace.DueBeforeTaking(1), start_);
  EXPECT_EQ(pace.DueBeforeSending(At(1'100'000)), start_ + milliseconds(100));
  EXPECT_EQ(pace.DueBeforeSending(At(1'350'000)), start_ + milliseconds(350));
}

TEST_F(PaceTest, TakesAStepBackAsNoneAndALongPauseAsTenSeconds) {
  Pace pace = Pace::AsRecorded();
  pace.Start(start_);
  pace.DueBeforeSending(At(1'000'000));
  EXPECT_EQ(pace.DueBeforeSending(At(400'000)), start_);
  EXPECT_EQ(pace.DueBeforeSending(At(500'000)), start_ + milliseconds(100));
  EXPECT_EQ(pace.DueBeforeSending(At(std::numeric_limits<int64_t>::max())),
            start_ + milliseconds(100) + seconds(10));
  EXPECT_EQ(pace.DueBeforeSending(At(0)), start_ + milliseconds(100) + seconds(10));
}

}  // namespace
}  // namespace sprout
