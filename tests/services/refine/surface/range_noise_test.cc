#include "services/refine/surface/range_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace sprout::refine {
namespace {

constexpr double kInfinityPx = -12;

// Of points whose noise is s Dᵏ px, at D = 10 to 200 px.
std::vector<Deviation> DeviationsOf(double scale, int power, int count) {
  cv::RNG random(7);
  std::vector<Deviation> deviations;
  for (int i = 0; i < count; ++i) {
    const double above_px = random.uniform(10.0, 200.0);
    const double sigma_px = scale * std::pow(above_px, power);
    const auto of_neighbours = [&] { return random.gaussian(sigma_px * std::sqrt(0.5)); };
    const double own = random.gaussian(sigma_px);
    const double off_px =
        std::max(std::abs(own - of_neighbours()), std::abs(own - of_neighbours()));
    deviations.push_back({.disparity_px = static_cast<float>(above_px + kInfinityPx),
                          .off_px = static_cast<float>(off_px)});
  }
  return deviations;
}

TEST(RangeNoise, TellsCamerasFromLidars) {
  for (const int power : {0, 1, 2}) {
    const double scale = 2 / std::pow(100, power);
    const RangeNoise noise = FindRangeNoise(DeviationsOf(scale, power, 20'000), kInfinityPx);
    EXPECT_EQ(noise.power, power);
    for (const double above_px : {20, 50, 100, 150}) {
      const double sigma_px = scale * std::pow(above_px, power);
      EXPECT_NEAR(noise.PxAt(kInfinityPx + above_px), sigma_px, 0.05 * sigma_px) << above_px;
    }
    EXPECT_NEAR(noise.middle_px, noise.PxAt(kInfinityPx + 105), 0.1) << power;
  }
}

TEST(RangeNoise, IsEvenWhereFewPointsShowIt) {
  EXPECT_EQ(FindRangeNoise(DeviationsOf(1e-3, 2, 150), kInfinityPx).power, 0);
  EXPECT_EQ(FindRangeNoise({}, 0).middle_px, 0);
}

TEST(RangeNoise, HasBounds) {
  const RangeNoise exact = FindRangeNoise(DeviationsOf(0, 0, 1000), kInfinityPx);
  EXPECT_EQ(exact.power, 0);
  EXPECT_EQ(exact.PxAt(50), 0.05);
  EXPECT_EQ((RangeNoise{.scale = 1, .power = 2}.PxAt(500)), 1000);
  EXPECT_EQ((RangeNoise{.scale = 1, .power = 2}.PxAt(-3)), 1);  // as at 1 px
}

}  // namespace
}  // namespace sprout::refine
