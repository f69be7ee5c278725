#include "services/capture/genicam/triplet_synchronizer.h"

#include <gmock/gmock.h>

#include <vector>

namespace sprout::capture {
namespace {

constexpr int64_t kStart = 1'700'000'000'000'000;
constexpr int64_t kPeriod = 100'000;

TimedImage At(int64_t utime) { return {.utime = utime, .image = {}, .tof = {}}; }

std::vector<Triplet> All(TripletSynchronizer& former, int64_t now) {
  std::vector<Triplet> triplets;
  while (std::optional<Triplet> triplet = former.Next(now)) triplets.push_back(std::move(*triplet));
  return triplets;
}

TEST(TripletSynchronizer, PairsByTimeWhateverTheOrderOfArrival) {
  TripletSynchronizer former({});
  former.Push(RigPlace::kTof, At(kStart + 2000));
  former.Push(RigPlace::kTof, At(kStart + kPeriod + 2000));
  former.Push(RigPlace::kRight, At(kStart + 1000));
  EXPECT_FALSE(former.Next(kStart));
  former.Push(RigPlace::kLeft, At(kStart));
  former.Push(RigPlace::kLeft, At(kStart + kPeriod));
  former.Push(RigPlace::kRight, At(kStart + kPeriod - 1000));
  const std::vector<Triplet> triplets = All(former, kStart + kPeriod);
  ASSERT_EQ(triplets.size(), 2);
  EXPECT_EQ(triplets[0].utime(), kStart + 500);
  EXPECT_EQ(triplets[0].spread_ms(), 2.0);
  EXPECT_EQ(triplets[1].utime(), kStart + kPeriod - 500);
  EXPECT_EQ(triplets[1].tof->utime, kStart + kPeriod + 2000);
  EXPECT_EQ(triplets[1].spread_ms(), 3.0);
}

TEST(TripletSynchronizer, CountsImagesWhosePartnerWasLost) {
  TripletSynchronizer former({});
  int64_t formed = 0;
  int64_t without_tof = 0;
  for (int64_t i = 0; i < 100; ++i) {
    if (i % 10 != 3) former.Push(RigPlace::kLeft, At(kStart + i * kPeriod));
    if (i % 10 != 5) former.Push(RigPlace::kRight, At(kStart + i * kPeriod + 100));
    if (i % 10 != 7) former.Push(RigPlace::kTof, At(kStart + i * kPeriod - 100));
    for (const Triplet& triplet : All(former, kStart + i * kPeriod)) {
      EXPECT_LE(triplet.spread_ms(), 0.2);
      ++formed;
      if (!triplet.tof) ++without_tof;
    }
  }
  EXPECT_EQ(formed, 80);
  EXPECT_EQ(without_tof, 10);
  EXPECT_EQ(former.unpaired(RigPlace::kLeft), 10);
  EXPECT_EQ(former.unpaired(RigPlace::kRight), 10);
  EXPECT_EQ(former.unpaired(RigPlace::kTof), 20);
}

TEST(TripletSynchronizer, WaitsForTheTofImageForALimitedTime) {
  TripletSynchronizer former({.max_spread_us = 5000, .has_tof = true, .max_wait_us = 300'000});
  former.Push(RigPlace::kLeft, At(kStart));
  former.Push(RigPlace::kRight, At(kStart));
  EXPECT_FALSE(former.Next(kStart + 300'000));
  const std::optional<Triplet> triplet = former.Next(kStart + 300'001);
  ASSERT_TRUE(triplet);
  EXPECT_FALSE(triplet->tof);
}

TEST(TripletSynchronizer, WaitsNoMoreForATofCameraThatIsSilentUntilItGivesAnImage) {
  TripletSynchronizer former({.max_spread_us = 5000, .has_tof = true, .max_wait_us = 300'000});
  const auto push_pair = [&](int64_t index) {
    former.Push(RigPlace::kLeft, At(kStart + index * kPeriod));
    former.Push(RigPlace::kRight, At(kStart + index * kPeriod));
  };
  push_pair(0);
  EXPECT_TRUE(former.Next(kStart + 300'001));
  push_pair(1);
  EXPECT_TRUE(former.Next(kStart + kPeriod));
  former.Push(RigPlace::kTof, At(kStart + kPeriod));
  push_pair(2);
  EXPECT_FALSE(former.Next(kStart + 2 * kPeriod));
  former.Push(RigPlace::kTof, At(kStart + 2 * kPeriod));
  EXPECT_TRUE(former.Next(kStart + 2 * kPeriod)->tof);
}

TEST(TripletSynchronizer, DoesNotWaitForATofCameraThatIsGoneOrMissing) {
  TripletSynchronizer without({.max_spread_us = 5000, .has_tof = false, .max_wait_us = 300'000});
  TripletSynchronizer gone({});
  gone.SetTofIsThere(false);
  for (TripletSynchronizer* former : {&without, &gone}) {
    former->Push(RigPlace::kLeft, At(kStart));
    former->Push(RigPlace::kRight, At(kStart));
    EXPECT_TRUE(former->Next(kStart));
  }
}

TEST(TripletSynchronizer, DoesNotWaitOnceALaterTofImageIsThere) {
  TripletSynchronizer former({});
  former.Push(RigPlace::kLeft, At(kStart));
  former.Push(RigPlace::kRight, At(kStart));
  former.Push(RigPlace::kTof, At(kStart + kPeriod));
  const std::optional<Triplet> triplet = former.Next(kStart);
  ASSERT_TRUE(triplet);
  EXPECT_FALSE(triplet->tof);
  EXPECT_EQ(former.unpaired(RigPlace::kTof), 0);
}

TEST(TripletSynchronizer, BearsACameraThatIsLate) {
  TripletSynchronizer former({});
  int64_t formed = 0;
  for (int64_t i = 0; i < 50; ++i) {
    former.Push(RigPlace::kLeft, At(kStart + i * kPeriod));
    former.Push(RigPlace::kTof, At(kStart + i * kPeriod));
    if (i >= 3) former.Push(RigPlace::kRight, At(kStart + (i - 3) * kPeriod));
    for (const Triplet& triplet : All(former, kStart + i * kPeriod)) {
      EXPECT_EQ(triplet.spread_ms(), 0);
      EXPECT_TRUE(triplet.tof);
      ++formed;
    }
  }
  EXPECT_EQ(formed, 47);
  EXPECT_EQ(former.unpaired(RigPlace::kLeft), 0);
}

TEST(TripletSynchronizer, GivesUpOnImagesOfOneCameraWithoutTheOther) {
  TripletSynchronizer former({.max_spread_us = 5000, .has_tof = true, .max_wait_us = 500'000});
  for (int64_t i = 0; i < 100; ++i) {
    former.Push(RigPlace::kLeft, At(kStart + i * kPeriod));
    former.Push(RigPlace::kTof, At(kStart + i * kPeriod));
    EXPECT_FALSE(former.Next(kStart + i * kPeriod));
  }
  EXPECT_EQ(former.unpaired(RigPlace::kLeft), 94);
  EXPECT_EQ(former.unpaired(RigPlace::kTof), 94);
}

TEST(TripletSynchronizer, TakesTheCloserOfTwoPartners) {
  // A right camera that is twice as fast, with a tolerance as long as its period.
  TripletSynchronizer former({.max_spread_us = 50'000, .has_tof = false, .max_wait_us = 500'000});
  for (int64_t i = 0; i < 20; ++i) {
    former.Push(RigPlace::kRight, At(kStart + i * kPeriod / 2));
  }
  for (int64_t i = 0; i < 10; ++i) former.Push(RigPlace::kLeft, At(kStart + i * kPeriod + 1000));
  const std::vector<Triplet> triplets = All(former, kStart + 10 * kPeriod);
  EXPECT_EQ(triplets.size(), 10);
  for (const Triplet& triplet : triplets) EXPECT_EQ(triplet.spread_ms(), 1.0);
  EXPECT_EQ(former.unpaired(RigPlace::kRight), 9);
}

TEST(TripletSynchronizer, FollowsACameraWhoseTimesStartAgain) {
  TripletSynchronizer former({.max_spread_us = 5000, .has_tof = false, .max_wait_us = 500'000});
  former.Push(RigPlace::kLeft, At(kStart + 10 * kPeriod));
  former.Push(RigPlace::kLeft, At(kStart));  // its clock jumped back
  EXPECT_EQ(former.unpaired(RigPlace::kLeft), 1);
  former.Push(RigPlace::kRight, At(kStart));
  EXPECT_TRUE(former.Next(kStart));
  former.Push(RigPlace::kLeft, At(kStart + kPeriod));
  former.Drop(RigPlace::kLeft);
  EXPECT_EQ(former.unpaired(RigPlace::kLeft), 2);
  former.Push(RigPlace::kRight, At(kStart + kPeriod));
  EXPECT_FALSE(former.Next(kStart + kPeriod));
}

TEST(TripletSynchronizer, PairsCamerasThatDriftUntilTheyArePartedTooFar) {
  // 1 % faster: after 5 images the right one is 5 ms ahead.
  TripletSynchronizer former({.max_spread_us = 5000, .has_tof = false, .max_wait_us = 500'000});
  // 0 to 5 with 0 to 5; once the right one is a whole period ahead, 94 to 100 with 95 to 101.
  int64_t formed = 0;
  for (int64_t i = 0; i < 102; ++i) {
    former.Push(RigPlace::kLeft, At(kStart + i * kPeriod));
    former.Push(RigPlace::kRight, At(kStart + i * kPeriod * 99 / 100));
    for (const Triplet& triplet : All(former, kStart + i * kPeriod)) {
      EXPECT_LE(triplet.spread_ms(), 5.0);
      ++formed;
    }
  }
  EXPECT_EQ(formed, 6 + 7);
}

}  // namespace
}  // namespace sprout::capture
