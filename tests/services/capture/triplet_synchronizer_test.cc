#include "services/capture/triplet_synchronizer.h"

#include <gmock/gmock.h>

#include <vector>

namespace sprout::capture {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;

constexpr int64_t kStart = 1'700'000'000'000'000;
constexpr int64_t kPeriod = 100'000;

TimedImage At(int64_t utime) { return {.utime = utime, .image = {}, .tof = {}}; }

std::vector<Triplet> All(TripletSynchronizer& joiner, int64_t now) {
  std::vector<Triplet> triplets;
  while (std::optional<Triplet> triplet = joiner.Next(now)) triplets.push_back(std::move(*triplet));
  return triplets;
}

TEST(TripletSynchronizer, PairsByTimeWhateverTheOrderOfArrival) {
  TripletSynchronizer joiner({});
  joiner.Push(RigPlace::kTof, At(kStart + 2000));
  joiner.Push(RigPlace::kTof, At(kStart + kPeriod + 2000));
  joiner.Push(RigPlace::kRight, At(kStart + 1000));
  EXPECT_FALSE(joiner.Next(kStart));
  joiner.Push(RigPlace::kLeft, At(kStart));
  joiner.Push(RigPlace::kLeft, At(kStart + kPeriod));
  joiner.Push(RigPlace::kRight, At(kStart + kPeriod - 1000));
  const std::vector<Triplet> triplets = All(joiner, kStart + kPeriod);
  ASSERT_EQ(triplets.size(), 2);
  EXPECT_EQ(triplets[0].utime(), kStart + 500);
  EXPECT_EQ(triplets[0].spread_ms(), 2.0);
  EXPECT_EQ(triplets[1].utime(), kStart + kPeriod - 500);
  EXPECT_EQ(triplets[1].tof->utime, kStart + kPeriod + 2000);
  EXPECT_EQ(triplets[1].spread_ms(), 3.0);
}

TEST(TripletSynchronizer, CountsImagesWhosePartnerWasLost) {
  TripletSynchronizer joiner({});
  int64_t formed = 0;
  int64_t without_tof = 0;
  for (int64_t i = 0; i < 100; ++i) {
    if (i % 10 != 3) joiner.Push(RigPlace::kLeft, At(kStart + i * kPeriod));
    if (i % 10 != 5) joiner.Push(RigPlace::kRight, At(kStart + i * kPeriod + 100));
    if (i % 10 != 7) joiner.Push(RigPlace::kTof, At(kStart + i * kPeriod - 100));
    for (const Triplet& triplet : All(joiner, kStart + i * kPeriod)) {
      EXPECT_LE(triplet.spread_ms(), 0.2);
      ++formed;
      if (!triplet.tof) ++without_tof;
    }
  }
  EXPECT_EQ(formed, 80);
  EXPECT_EQ(without_tof, 10);
  EXPECT_EQ(joiner.unpaired(RigPlace::kLeft), 10);
  EXPECT_EQ(joiner.unpaired(RigPlace::kRight), 10);
  EXPECT_EQ(joiner.unpaired(RigPlace::kTof), 20);
}

TEST(TripletSynchronizer, WaitsForTheTofImageForALimitedTime) {
  TripletSynchronizer joiner({.max_spread_us = 5000, .has_tof = true, .max_wait_us = 300'000});
  joiner.Push(RigPlace::kLeft, At(kStart));
  joiner.Push(RigPlace::kRight, At(kStart));
  EXPECT_FALSE(joiner.Next(kStart + 300'000));
  const Triplet triplet = joiner.Next(kStart + 300'001).value();
  EXPECT_FALSE(triplet.tof);
}

TEST(TripletSynchronizer, WaitsNoMoreForATofCameraThatIsSilentUntilItGivesAnImage) {
  TripletSynchronizer joiner({.max_spread_us = 5000, .has_tof = true, .max_wait_us = 300'000});
  const auto push_pair = [&](int64_t index) {
    joiner.Push(RigPlace::kLeft, At(kStart + index * kPeriod));
    joiner.Push(RigPlace::kRight, At(kStart + index * kPeriod));
  };
  push_pair(0);
  EXPECT_TRUE(joiner.Next(kStart + 300'001));
  push_pair(1);
  EXPECT_TRUE(joiner.Next(kStart + kPeriod));
  joiner.Push(RigPlace::kTof, At(kStart + kPeriod));
  push_pair(2);
  EXPECT_FALSE(joiner.Next(kStart + 2 * kPeriod));
  joiner.Push(RigPlace::kTof, At(kStart + 2 * kPeriod));
  EXPECT_TRUE(joiner.Next(kStart + 2 * kPeriod)->tof);
}

TEST(TripletSynchronizer, DoesNotWaitForATofCameraThatIsGoneOrMissing) {
  TripletSynchronizer without({.max_spread_us = 5000, .has_tof = false, .max_wait_us = 300'000});
  TripletSynchronizer gone({});
  gone.SetTofIsThere(false);
  for (TripletSynchronizer* joiner : {&without, &gone}) {
    joiner->Push(RigPlace::kLeft, At(kStart));
    joiner->Push(RigPlace::kRight, At(kStart));
    EXPECT_TRUE(joiner->Next(kStart));
  }
}

TEST(TripletSynchronizer, DoesNotWaitOnceALaterTofImageIsThere) {
  TripletSynchronizer joiner({});
  joiner.Push(RigPlace::kLeft, At(kStart));
  joiner.Push(RigPlace::kRight, At(kStart));
  joiner.Push(RigPlace::kTof, At(kStart + kPeriod));
  const Triplet triplet = joiner.Next(kStart).value();
  EXPECT_FALSE(triplet.tof);
  EXPECT_EQ(joiner.unpaired(RigPlace::kTof), 0);
}

TEST(TripletSynchronizer, BearsACameraThatIsLate) {
  TripletSynchronizer joiner({});
  int64_t formed = 0;
  for (int64_t i = 0; i < 50; ++i) {
    joiner.Push(RigPlace::kLeft, At(kStart + i * kPeriod));
    joiner.Push(RigPlace::kTof, At(kStart + i * kPeriod));
    if (i >= 3) joiner.Push(RigPlace::kRight, At(kStart + (i - 3) * kPeriod));
    for (const Triplet& triplet : All(joiner, kStart + i * kPeriod)) {
      EXPECT_EQ(triplet.spread_ms(), 0);
      EXPECT_TRUE(triplet.tof);
      ++formed;
    }
  }
  EXPECT_EQ(formed, 47);
  EXPECT_EQ(joiner.unpaired(RigPlace::kLeft), 0);
}

TEST(TripletSynchronizer, GivesUpOnImagesOfOneCameraWithoutTheOther) {
  TripletSynchronizer joiner({.max_spread_us = 5000, .has_tof = true, .max_wait_us = 500'000});
  for (int64_t i = 0; i < 100; ++i) {
    joiner.Push(RigPlace::kLeft, At(kStart + i * kPeriod));
    joiner.Push(RigPlace::kTof, At(kStart + i * kPeriod));
    EXPECT_FALSE(joiner.Next(kStart + i * kPeriod));
  }
  EXPECT_EQ(joiner.unpaired(RigPlace::kLeft), 94);
  EXPECT_EQ(joiner.unpaired(RigPlace::kTof), 94);
}

TEST(TripletSynchronizer, TakesTheCloserOfTwoPartners) {
  // A right camera that is twice as fast, with a tolerance as long as its period.
  TripletSynchronizer joiner({.max_spread_us = 50'000, .has_tof = false, .max_wait_us = 500'000});
  for (int64_t i = 0; i < 20; ++i) {
    joiner.Push(RigPlace::kRight, At(kStart + i * kPeriod / 2));
  }
  for (int64_t i = 0; i < 10; ++i) joiner.Push(RigPlace::kLeft, At(kStart + i * kPeriod + 1000));
  const std::vector<Triplet> triplets = All(joiner, kStart + 10 * kPeriod);
  EXPECT_EQ(triplets.size(), 10);
  for (const Triplet& triplet : triplets) EXPECT_EQ(triplet.spread_ms(), 1.0);
  EXPECT_EQ(joiner.unpaired(RigPlace::kRight), 9);
}

// Right comes first, so that of cameras with 60 images a second each left one could take the next.
TEST(TripletSynchronizer, ALostImageShiftsNoPairOfFastCameras) {
  constexpr int64_t kFast = 16'667;
  TripletSynchronizer joiner({.max_spread_us = 20'000});
  std::vector<Triplet> triplets;
  for (int64_t i = 0; i < 40; ++i) {
    const auto push = [&](RigPlace place, int64_t utime) {
      joiner.Push(place, At(kStart + utime));
      for (Triplet& triplet : All(joiner, kStart + utime)) triplets.push_back(std::move(triplet));
    };
    if (i != 10 && i != 31) push(RigPlace::kRight, i * kFast - 1000);
    if (i != 15 && i != 30) push(RigPlace::kLeft, i * kFast);
    if (i != 20) push(RigPlace::kTof, i * kFast + 500);
  }
  for (const Triplet& triplet : triplets) EXPECT_LE(triplet.spread_ms(), 1.5);
  EXPECT_EQ(triplets.size(), 36);
  EXPECT_EQ(joiner.tof_joins().joined, 35);
}

TEST(TripletSynchronizer, FollowsACameraWhoseTimesStartAgain) {
  TripletSynchronizer joiner({.max_spread_us = 5000, .has_tof = false, .max_wait_us = 500'000});
  joiner.Push(RigPlace::kLeft, At(kStart + 10 * kPeriod));
  joiner.Push(RigPlace::kLeft, At(kStart));  // its clock jumped back
  EXPECT_EQ(joiner.unpaired(RigPlace::kLeft), 1);
  joiner.Push(RigPlace::kRight, At(kStart));
  EXPECT_TRUE(joiner.Next(kStart));
  joiner.Push(RigPlace::kLeft, At(kStart + kPeriod));
  joiner.Drop(RigPlace::kLeft);
  EXPECT_EQ(joiner.unpaired(RigPlace::kLeft), 2);
  joiner.Push(RigPlace::kRight, At(kStart + kPeriod));
  EXPECT_FALSE(joiner.Next(kStart + kPeriod));
}

TEST(TripletSynchronizer, PairsCamerasThatDriftUntilTheyArePartedTooFar) {
  // 1 % faster: after 5 images the right one is 5 ms ahead.
  TripletSynchronizer joiner({.max_spread_us = 5000, .has_tof = false, .max_wait_us = 500'000});
  // 0 to 5 with 0 to 5; once the right one is a whole period ahead, 94 to 100 with 95 to 101.
  int64_t formed = 0;
  for (int64_t i = 0; i < 102; ++i) {
    joiner.Push(RigPlace::kLeft, At(kStart + i * kPeriod));
    joiner.Push(RigPlace::kRight, At(kStart + i * kPeriod * 99 / 100));
    for (const Triplet& triplet : All(joiner, kStart + i * kPeriod)) {
      EXPECT_LE(triplet.spread_ms(), 5.0);
      ++formed;
    }
  }
  EXPECT_EQ(formed, 6 + 7);
}

// 20 pairs of 1 Hz, and ToF images whose stamps are so much later and that come before their pair.
std::string TroubleOf(int64_t tof_later_us, bool tof_comes = true) {
  TripletSynchronizer joiner({.max_spread_us = 20'000, .has_tof = true});
  for (int64_t i = 0; i < 20; ++i) {
    const int64_t utime = kStart + i * 10 * kPeriod;
    if (tof_comes) joiner.Push(RigPlace::kTof, At(utime + tof_later_us));
    joiner.Push(RigPlace::kLeft, At(utime));
    EXPECT_FALSE(joiner.Next(utime));
    joiner.Push(RigPlace::kRight, At(utime));
    EXPECT_EQ(All(joiner, utime + 6 * kPeriod).size(), 1U);
  }
  return JoinTrouble(joiner.tof_joins(), joiner.config(), "/points", /*at_end=*/true);
}

TEST(JoinTrouble, NamesTheSmallestDifferenceOfStamps) {
  EXPECT_EQ(TroubleOf(20'000), "");
  EXPECT_THAT(TroubleOf(30'000), HasSubstr("0 of 20 range images of /points joined 20 pairs"));
  EXPECT_THAT(TroubleOf(30'000), HasSubstr("the nearest is +30.0 ms off, max_spread_ms is 20"));
  EXPECT_THAT(TroubleOf(-40'000), HasSubstr("the nearest is -40.0 ms off"));
}

TEST(JoinTrouble, NamesAnotherClockWhicheverIsBehind) {
  constexpr int64_t kHour = 3'600'000'000;
  for (const int64_t later : {kHour, -kHour}) {
    // The nearest of 20 pairs, 1 s apart, is up to 19 s less off.
    EXPECT_THAT(TroubleOf(later), ContainsRegex("nearest is [+-]3(58|60)[0-9]{4}.0 ms off"));
    EXPECT_THAT(TroubleOf(later), HasSubstr("is that another clock, or are there no stamps?"));
  }
}

// Two recordings that are played in the order of clocks that are hours apart.
TEST(JoinTrouble, SaysThatAllCameAfterThePairs) {
  TripletSynchronizer joiner({.max_spread_us = 20'000, .has_tof = true});
  joiner.Push(RigPlace::kLeft, At(kStart));
  joiner.Push(RigPlace::kRight, At(kStart));
  EXPECT_EQ(All(joiner, kStart + 6 * kPeriod).size(), 1U);
  joiner.Push(RigPlace::kTof, At(kStart));
  EXPECT_THAT(JoinTrouble(joiner.tof_joins(), joiner.config(), "/points", /*at_end=*/true),
              HasSubstr("none the last 1: all came before or after the images; allowed is one "));
}

TEST(JoinTrouble, SaysThatNoneCame) {
  EXPECT_EQ(TroubleOf(0, /*tof_comes=*/false),
            "no range image came with 20 pairs: does /points send any?");
}

TEST(JoinTrouble, WhileImagesComeSaysSoAfterTenAHundredPairsInARow) {
  TofJoins joins{.pairs = 10, .came = 9, .joined = 0, .pairs_since_join = 9};
  const TripletConfig config;
  EXPECT_EQ(JoinTrouble(joins, config, "ToF", /*at_end=*/false), "");
  joins.pairs_since_join = 10;
  EXPECT_NE(JoinTrouble(joins, config, "ToF", /*at_end=*/false), "");
  joins.longest_gap = 5;  // a slow sensor has such gaps
  EXPECT_EQ(JoinTrouble(joins, config, "ToF", /*at_end=*/false), "");
  joins.pairs_since_join = 100;
  EXPECT_NE(JoinTrouble(joins, config, "ToF", /*at_end=*/false), "");
}

// Of a slower or a faster sensor than the cameras, one a pair or all can join.
TEST(JoinTrouble, SaysAtTheEndWhereManyDidNotJoin) {
  const auto of = [](int64_t pairs, int64_t came, int64_t joined) {
    return JoinTrouble({.pairs = pairs, .came = came, .joined = joined}, {}, "ToF", true);
  };
  EXPECT_EQ(of(20, 20, 14), "");
  EXPECT_EQ(of(20, 20, 13), "13 of 20 range images of ToF joined 20 pairs");
  EXPECT_EQ(of(20, 5, 4), "");
  EXPECT_EQ(of(20, 90, 19), "");
  EXPECT_EQ(of(0, 9, 0), "");
}

}  // namespace
}  // namespace sprout::capture
