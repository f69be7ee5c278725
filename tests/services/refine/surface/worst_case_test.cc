// What crowds into a few pixels must not take refinement longer than what is spread.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "services/refine/refiner.h"
#include "services/refine/surface/background.h"
#include "services/refine/surface/tof_surface.h"
#include "tests/common/core/centred.h"
#include "tests/common/testing/worst_seeds.h"

namespace sprout::refine {
namespace {

const cv::Size kWorstSize(640, 480);

// As many ToF pixels as there are seeds.
TofCamera WideTof() {
  TofCamera tof;
  tof.width = 500;
  tof.height = kWorstCount / tof.width;
  tof.cx = tof.width / 2.0;
  tof.cy = tof.height / 2.0;
  return tof;
}

Rig WorstRig() { return {CentredPair(kWorstSize.width, kWorstSize.height, 500), WideTof()}; }

cv::Mat1b Noise(int seed) {
  cv::Mat1b noise(kWorstSize);
  cv::RNG(static_cast<uint64_t>(seed)).fill(noise, cv::RNG::UNIFORM, 1, 255);
  return noise;
}

TEST(WorstCase, TheBackgroundRuleIsNotQuadratic) {
  for (const auto& [name, seeds] : MakeWorstSeeds(kWorstSize)) {
    BackgroundRule rule;
    EXPECT_LT(CpuSeconds([&] { rule.Find(seeds, kWorstSize, 1); }), kWorstSeconds) << name;
  }
}

// Of all seeds that are within a window of another, as the rule is written.
TEST(WorstCase, TheBackgroundRuleFindsTheSameAmongSeedsInTheSamePixels) {
  std::mt19937 random(1);
  std::vector<Seed> seeds;
  const auto place = [&](int range) { return static_cast<float>(random() % range); };
  for (int i = 0; i < 2000; ++i) {
    seeds.push_back({30 + place(120) / 16, 20 + place(96) / 16, 15 + place(80) / 16});
  }
  const auto shares_window = [](float a, float b) {
    return std::abs(std::round(a) - std::round(b)) <= 2;
  };
  std::vector<uint8_t> expected(seeds.size(), 0);
  for (float Seed::*column : {&Seed::u, &Seed::u_right}) {
    for (const Seed& centre : seeds) {
      const auto in_window = [&](const Seed& seed) {
        return shares_window(seed.*column, centre.*column) && shares_window(seed.v, centre.v);
      };
      float nearest = 0;
      for (const Seed& seed : seeds) {
        if (in_window(seed)) nearest = std::max(nearest, seed.disparity());
      }
      for (size_t i = 0; i < seeds.size(); ++i) {
        if (in_window(seeds[i]) && seeds[i].disparity() < nearest - 4.0) expected[i] = 1;
      }
    }
  }
  const auto kept = std::count(expected.begin(), expected.end(), 0);
  EXPECT_GT(kept, 100);
  EXPECT_LT(kept, 1900);
  EXPECT_EQ(BackgroundRule().Find(seeds, {100, 80}, 4), expected);
}

// ToF pixels 10 px apart in the images, and all points on a few pixels: each is in reach of every
// other, and the images agree with none.
TEST(WorstCase, TheHiddenRuleIsNotQuadratic) {
  Rig rig = WorstRig();
  rig.tof.fx = rig.tof.fy = 50;
  const cv::Mat1b left = Noise(1);
  const cv::Mat1b right = Noise(2);
  for (const auto& [name, seeds] : MakeWorstSeeds(kWorstSize)) {
    if (name != "one pixel" && name != "everywhere") continue;  // the two that take longest
    std::vector<ProjectedPoint> points;
    for (size_t i = 0; i < seeds.size(); ++i) {
      const int pixel = static_cast<int>(i);
      points.push_back({pixel % rig.tof.width, pixel / rig.tof.width, seeds[i]});
    }
    TofSurface surface(rig, points);
    const HiddenRule rule{.core = 0, .reach = 2, .tolerance_px = 0};
    EXPECT_LT(CpuSeconds([&] { surface.FindHidden(points, points.size(), left, right, rule); }),
              kWorstSeconds)
        << name;
  }
}

// Of a range image finer than the pair most points are out of a piece's reach.
TEST(WorstCase, FinePiecesAreFoundAsFastAsCoarseOnes) {
  const auto seconds = [](float step_px) {
    Rig rig = WorstRig();
    rig.tof.width = 500;
    rig.tof.height = 400;
    rig.tof.fx = rig.tof.fy = rig.pair.focal_px / step_px;
    std::vector<ProjectedPoint> points;
    for (int y = 0; y < rig.tof.height; ++y) {
      for (int x = 0; x < rig.tof.width; ++x) {
        const float u = 100 + static_cast<float>(x) * step_px;
        const float disparity = 20 + static_cast<float>(x % 40) / 8;
        points.push_back({x, y, {u, 20 + static_cast<float>(y) * step_px, u - disparity}});
      }
    }
    TofSurface surface(rig, points);
    const HiddenRule rule{.core = 0.4, .reach = 0.8, .tolerance_px = 1};
    const cv::Mat1b grey = Noise(1);
    return CpuSeconds([&] { surface.FindHidden(points, points.size(), grey, grey, rule); });
  };
  EXPECT_LT(seconds(0.25), 5 * seconds(1));
}

TEST(WorstCase, AmongPointsThatCrowdTheNearestHide) {
  const Rig rig = WorstRig();
  const cv::Mat1b grey(kWorstSize, uint8_t{100});
  std::vector<ProjectedPoint> points;
  for (int i = 0; i < 400; ++i) {
    points.push_back({i, 0, {320, 240, 320 - static_cast<float>(i) / 4}});
  }
  TofSurface surface(rig, points);
  const HiddenRule rule{.core = 1, .reach = 1, .tolerance_px = 1};
  const std::vector<Hidden> hidden = surface.FindHidden(points, points.size(), grey, grey, rule);
  for (size_t i = 0; i < points.size(); ++i) EXPECT_EQ(hidden[i].from_left, i < 395) << i;
  std::reverse(points.begin(), points.end());
  std::vector<Hidden> backwards = surface.FindHidden(points, points.size(), grey, grey, rule);
  std::reverse(backwards.begin(), backwards.end());
  EXPECT_EQ(hidden, backwards);
}

// A calibration whose ToF camera sees a single pixel of the images with all of its own.
TEST(WorstCase, AFrameWhoseToFPointsShareAPixelIsRefinedInTime) {
  Rig rig = WorstRig();
  rig.tof.fx = rig.tof.fy = 1e6;
  TofImage tof{.depth_m = cv::Mat1f(rig.tof.height, rig.tof.width), .amplitude = {}};
  cv::RNG(3).fill(tof.depth_m, cv::RNG::UNIFORM, 0.5F, 5.F);
  RefineConfig config;
  config.set_background_tolerance_px(1);
  config.set_loose_tolerance_px(0);
  Refiner refiner(config);
  const TofProjector projector(rig);
  const cv::Mat1b left = Noise(1);
  const cv::Mat1b right = Noise(2);
  Result<SeedSet> seeds;
  EXPECT_LT(CpuSeconds([&] { seeds = refiner.Compute(left, right, tof, projector); }),
            kWorstSeconds);
  EXPECT_EQ(seeds->raw, kWorstCount);
}

}  // namespace
}  // namespace sprout::refine
