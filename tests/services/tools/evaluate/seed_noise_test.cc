#include <gtest/gtest.h>

#include <cmath>

#include "services/tools/evaluate/chain.h"

namespace sprout::evaluate {
namespace {

std::vector<Seed> ManySeeds() {
  std::vector<Seed> seeds;
  for (int i = 0; i < 20000; ++i) {
    const auto u = static_cast<float>(100 + i % 500);
    seeds.push_back({.u = u, .v = static_cast<float>(i / 500), .u_right = u - 50});
  }
  return seeds;
}

TEST(SeedNoise, LeavesSeedsAloneWhenThereIsNone) {
  EXPECT_EQ(AddNoise(ManySeeds(), {.seed = 5}), ManySeeds());
}

TEST(SeedNoise, MovesSeedsAndLeavesTheRestOfThemAlone) {
  const Seed seed{.u = 9, .v = 8, .u_right = 7, .sigma_px = 3, .tof_u = 5, .tof_v = 6};
  std::vector<Seed> noisy = AddNoise({seed}, {.disparity_px = 1, .jitter_px = 1, .seed = 2});
  EXPECT_NE(noisy[0].u, seed.u);
  noisy[0].u = seed.u;
  noisy[0].v = seed.v;
  noisy[0].u_right = seed.u_right;
  noisy[0].sigma_px = seed.sigma_px;
  EXPECT_EQ(noisy[0], seed);
}

TEST(SeedNoise, RepeatsItselfForTheSameSeed) {
  const SeedNoise noise{.disparity_px = 1, .jitter_px = 2, .seed = 7};
  EXPECT_EQ(AddNoise(ManySeeds(), noise), AddNoise(ManySeeds(), noise));
}

// These numbers and the next ones are from an implementation of the engine (mt19937_64) and the
// transform in another language.
TEST(SeedNoise, DiffersForAnotherSeed) {
  const std::vector<Seed> two(2, {.u = 100, .v = 20, .u_right = 50});
  const auto noisy = [&](uint64_t seed) {
    return AddNoise(two, {.disparity_px = 1, .jitter_px = 1, .seed = seed});
  };
  EXPECT_NEAR(noisy(7)[0].disparity(), 50.713030, 1e-4);
  EXPECT_NEAR(noisy(7)[0].u, 99.234829, 1e-4);
  EXPECT_NEAR(noisy(7)[1].disparity(), 51.861064, 1e-4);
  EXPECT_NEAR(noisy(7)[1].v, 20.801421, 1e-4);
  EXPECT_NEAR(noisy(8)[0].disparity(), 51.046643, 1e-4);
  EXPECT_NEAR(noisy(8)[0].u, 100.724638, 1e-4);
  EXPECT_NEAR(noisy(8)[1].disparity(), 48.864549, 1e-4);
  EXPECT_NEAR(noisy(8)[1].v, 19.926150, 1e-4);
}

TEST(SeedNoise, GivesTheSameNumbersOnEveryMachine) {
  const std::vector<Seed> noisy = AddNoise({{.u = 100, .v = 20, .u_right = 50}},
                                           {.disparity_px = 1, .jitter_px = 1, .seed = 1});
  EXPECT_NEAR(noisy[0].u, 99.902428, 1e-4);
  EXPECT_NEAR(noisy[0].v, 19.042049, 1e-4);
  EXPECT_NEAR(noisy[0].disparity(), 51.312851, 1e-4);
}

TEST(SeedNoise, IsGaussianInDisparityOnly) {
  const std::vector<Seed> seeds = ManySeeds();
  const std::vector<Seed> noisy = AddNoise(seeds, {.disparity_px = 3, .seed = 1});
  double sum = 0;
  double sum_squares = 0;
  int within_one_sigma = 0;
  for (size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_EQ(noisy[i].u, seeds[i].u);
    EXPECT_EQ(noisy[i].v, seeds[i].v);
    const double error = noisy[i].disparity() - seeds[i].disparity();
    sum += error;
    sum_squares += error * error;
    within_one_sigma += std::abs(error) <= 3;
  }
  const auto n = static_cast<double>(seeds.size());
  EXPECT_NEAR(sum / n, 0, 0.1);
  EXPECT_NEAR(std::sqrt(sum_squares / n), 3, 0.1);
  EXPECT_NEAR(within_one_sigma / n, 0.683, 0.02);
}

TEST(SeedNoise, IsSaidByTheSeedsAndLeavesThoseOfStereoAlone) {
  const Seed tof{.u = 9, .v = 8, .u_right = 7, .sigma_px = 3};
  const Seed stereo{.u = 9, .v = 8, .u_right = 7, .sigma_px = 3, .origin = SeedOrigin::kStereo};
  const std::vector<Seed> noisy = AddNoise({tof, stereo}, {.disparity_px = 4, .seed = 1});
  EXPECT_FLOAT_EQ(noisy[0].sigma_px, 5);
  EXPECT_EQ(noisy[1], stereo);
}

TEST(SeedNoise, JittersPositionsUniformlyAndKeepsDisparities) {
  const std::vector<Seed> seeds = ManySeeds();
  const std::vector<Seed> noisy = AddNoise(seeds, {.jitter_px = 2, .seed = 1});
  int inner_half = 0;
  for (size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_NEAR(noisy[i].disparity(), 50, 1e-3);
    EXPECT_LE(std::abs(noisy[i].u - seeds[i].u), 2.001);
    EXPECT_LE(std::abs(noisy[i].v - seeds[i].v), 2.001);
    inner_half += std::abs(noisy[i].u - seeds[i].u) <= 1;
  }
  EXPECT_NEAR(inner_half / static_cast<double>(seeds.size()), 0.5, 0.02);
}

TEST(SeedNoise, OfOneKindDoesNotChangeWithTheAmountOfTheOther) {
  const std::vector<Seed> still = AddNoise(ManySeeds(), {.disparity_px = 1, .seed = 3});
  const std::vector<Seed> moved =
      AddNoise(ManySeeds(), {.disparity_px = 1, .jitter_px = 5, .seed = 3});
  for (size_t i = 0; i < still.size(); ++i) {
    EXPECT_NEAR(still[i].disparity(), moved[i].disparity(), 1e-3);
  }
}

}  // namespace
}  // namespace sprout::evaluate
