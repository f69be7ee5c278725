#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "services/prior/delaunay.h"
#include "services/prior/interpolation.h"
#include "services/prior/prior_plug.h"

namespace sprout {
namespace {

using testing::HasSubstr;

Seed SeedAt(double u, double v, double disparity) {
  const auto left = static_cast<float>(u);
  return {.u = left, .v = static_cast<float>(v), .u_right = left - static_cast<float>(disparity)};
}

std::vector<Seed> RandomSeeds(cv::Size size, int count, uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](int end) { return static_cast<double>(random() % 65536) / 65536 * end; };
  std::vector<Seed> seeds;
  for (int i = 0; i < count; ++i) {
    const double u = uniform(size.width);
    const double v = uniform(size.height);
    seeds.push_back(SeedAt(u, v, uniform(60)));
  }
  return seeds;
}

// Barycentric coordinates of a pixel in a triangle; nothing when it lies outside.
std::optional<double> Interpolate(const std::array<Seed, 3>& t, double u, double v) {
  const auto cross = [](const Seed& a, const Seed& b, double x, double y) {
    return (double{b.u} - a.u) * (y - a.v) - (double{b.v} - a.v) * (x - a.u);
  };
  const double area = cross(t[0], t[1], t[2].u, t[2].v);
  const double w0 = cross(t[1], t[2], u, v) / area;
  const double w1 = cross(t[2], t[0], u, v) / area;
  const double w2 = cross(t[0], t[1], u, v) / area;
  constexpr double kRounding = 1e-9;
  if (std::min({w0, w1, w2}) < -kRounding) return std::nullopt;
  return w0 * t[0].disparity() + w1 * t[1].disparity() + w2 * t[2].disparity();
}

Result<DisparityImage> Interpolated(const std::vector<Seed>& seeds, cv::Size size) {
  return InterpolateSeeds(seeds, TriangulateSeeds(seeds), size);
}

TEST(Prior, EqualsBruteForcePointInTriangleInterpolation) {
  const cv::Size size(90, 70);
  for (uint32_t seed = 0; seed < 8; ++seed) {
    const std::vector<Seed> seeds = RandomSeeds(size, 5 + 10 * static_cast<int>(seed), seed);
    const auto prior = Interpolated(seeds, size);
    ASSERT_TRUE(prior.has_value());
    const auto triangles = TriangulateSeeds(seeds);
    int inside = 0;
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        for (const auto& [a, b, c] : triangles) {
          const auto expected =
              Interpolate({seeds[static_cast<size_t>(a)], seeds[static_cast<size_t>(b)],
                           seeds[static_cast<size_t>(c)]},
                          u, v);
          if (!expected) continue;
          ++inside;
          // Half a count of rounding; slivers lose a little more to their tiny area.
          EXPECT_NEAR(prior->Px(u, v), *expected, 0.55 / DisparityImage::kCountsPerPixel)
              << "seed " << seed << " at (" << u << ", " << v << ")";
          break;
        }
      }
    }
    EXPECT_GT(inside, 1000);
  }
}

TEST(Prior, ReproducesAPlaneExactly) {
  const cv::Size size(64, 48);
  const auto plane = [](double u, double v) { return 10 + u / 8 + v / 16; };
  std::vector<Seed> seeds;
  for (int v = 0; v < 48; v += 8) {
    for (int u = 0; u < 64; u += 8) seeds.push_back(SeedAt(u, v, plane(u, v)));
  }
  const auto prior = Interpolated(seeds, size);
  for (int v = 0; v <= 40; ++v) {
    for (int u = 0; u <= 56; ++u) EXPECT_EQ(prior->Px(u, v), static_cast<float>(plane(u, v)));
  }
}

TEST(Prior, TakesTheNearestHullValueOutsideTheHull) {
  const std::vector<Seed> seeds = {SeedAt(20, 10, 4), SeedAt(40, 10, 8), SeedAt(40, 30, 8),
                                   SeedAt(20, 30, 4)};
  const auto prior = Interpolated(seeds, {64, 48});
  EXPECT_EQ(prior->CountValid(), 64 * 48);
  EXPECT_EQ(prior->Px(0, 20), 4);
  EXPECT_EQ(prior->Px(0, 0), 4);
  EXPECT_EQ(prior->Px(30, 0), 6);
  EXPECT_EQ(prior->Px(30, 47), 6);
  EXPECT_EQ(prior->Px(63, 47), 8);
}

TEST(Prior, TakesTheFirstOfSeedsOnOnePosition) {
  const std::vector<Seed> seeds = {SeedAt(10, 10, 5), SeedAt(50, 10, 5), SeedAt(10, 40, 5),
                                   SeedAt(10, 10, 50)};
  EXPECT_EQ(Interpolated(seeds, {64, 48})->Px(12, 12), 5);
}

TEST(Prior, SaysWhyThereIsNone) {
  const cv::Size size(64, 48);
  EXPECT_THAT(Interpolated({}, size).error().text, HasSubstr("0 seeds"));
  EXPECT_THAT(Interpolated(std::vector<Seed>{SeedAt(1, 1, 1)}, size).error().text,
              HasSubstr("1 seeds"));
  EXPECT_THAT(Interpolated(std::vector<Seed>{SeedAt(1, 1, 1), SeedAt(9, 1, 1)}, size).error().text,
              HasSubstr("at least 3"));
  EXPECT_THAT(
      Interpolated(std::vector<Seed>{SeedAt(1, 1, 1), SeedAt(9, 9, 1), SeedAt(20, 20, 1)}, size)
          .error()
          .text,
      HasSubstr("on one line"));
  EXPECT_THAT(
      Interpolated(std::vector<Seed>{SeedAt(1.1, 1.1, 1), SeedAt(1.2, 1.1, 1), SeedAt(1.1, 1.2, 1)},
                   size)
          .error()
          .text,
      HasSubstr("cover no pixel"));
}

TEST(Prior, SurvivesSeedsOutsideTheImage) {
  const std::vector<Seed> seeds = {SeedAt(-500, -500, 3), SeedAt(5000, -100, 3),
                                   SeedAt(100, 9000, 3)};
  const auto prior = Interpolated(seeds, {64, 48});
  EXPECT_EQ(prior->CountValid(), 64 * 48);
  EXPECT_EQ(prior->Px(30, 30), 3);
}

TEST(PriorPlug, AnswersADegenerateFrameWithAnEmptyMap) {
  PriorConfig config;
  config.set_method(PriorConfig::DELAUNAY);
  Frame frame;
  frame.rig.emplace();
  frame.rig->pair.width = 64;
  frame.rig->pair.height = 48;
  frame.left = cv::Mat(48, 64, CV_8UC1);
  frame.seeds = SeedSet{.seeds = {SeedAt(1, 1, 1)}, .raw = 1};
  frame.left_seeds = SeedSet();
  const Outcome outcome = PriorPlug(config).Process(frame);
  EXPECT_THAT(outcome.degenerate, HasSubstr("at least 3"));
  ASSERT_EQ(outcome.outputs.size(), 1u);
  EXPECT_EQ(outcome.outputs[0].part, Part::kPrior);
  const auto& map = std::get<PriorMap>(outcome.outputs[0].value);
  EXPECT_EQ(map.size(), cv::Size(64, 48));
  EXPECT_EQ(map.disparity.CountValid(), 0);
}

TEST(Prior, SaysHowSureItIsBetweenItsSeedsAndThatItKnowsNothingBeyond) {
  PriorConfig config;
  config.set_method(PriorConfig::DELAUNAY);
  config.set_extend_to_border(false);
  std::vector<Seed> seeds = {SeedAt(10, 10, 5), SeedAt(50, 10, 5), SeedAt(30, 40, 5)};
  for (Seed& seed : seeds) seed.sigma_px = 0.75;
  const PriorMap prior = PriorEstimator(config).Compute({}, {}, seeds, {64, 48}).value();
  EXPECT_EQ(prior.sigma(20, 30), SigmaToCounts(0.75));
  EXPECT_EQ(prior.sigma(45, 2), kMaxSigmaCounts);
}

// A steep slant ends at the last seeds: beyond there is no depth that anybody saw.
TEST(Prior, StaysWithinWhatItsSeedsSaw) {
  const cv::Size size(400, 100);
  std::vector<Seed> seeds;
  for (int v = 10; v < 100; v += 10) {
    for (int u = 100; u < 300; u += 10) {
      seeds.push_back(
          SeedAt(static_cast<float>(u), static_cast<float>(v), 0.2F * static_cast<float>(u - 80)));
    }
  }
  const cv::Mat1b flat(size, uint8_t{100});
  const PriorMap prior = PriorEstimator(PriorConfig()).Compute(flat, flat, seeds, size).value();
  double least = 0;
  double most = 0;
  cv::minMaxLoc(prior.disparity.counts(), &least, &most);
  EXPECT_GE(least / 32, 4 - 1);
  EXPECT_LE(most / 32, 42 + 1);
  EXPECT_LT(prior.disparity.Px(85, 50), 4);  // it does go on for a little
}

TEST(PriorPlug, AnswersWithTheSizeOfTheImagesWhateverTheCalibrationClaims) {
  Frame frame;
  frame.rig.emplace();
  frame.rig->pair.width = frame.rig->pair.height = 10000;
  frame.left = frame.right = cv::Mat(48, 64, CV_8UC1, cv::Scalar(7));
  frame.seeds = SeedSet{.seeds = {SeedAt(0, 0, 5), SeedAt(9, 0, 5), SeedAt(1, 9, 5)}, .raw = 3};
  frame.left_seeds = SeedSet();
  for (const auto method : {PriorConfig::DELAUNAY, PriorConfig::FGS, PriorConfig::EDGES}) {
    PriorConfig config;
    config.set_method(method);
    PriorPlug plug(config);
    EXPECT_TRUE(plug.Inputs().Has(Part::kLeft));
    const Outcome outcome = plug.Process(frame);
    EXPECT_THAT(outcome.degenerate, HasSubstr("64x48: allowed is the calibrated size 10000x10000"));
    EXPECT_EQ(std::get<PriorMap>(outcome.outputs[0].value).size(), cv::Size(64, 48));
  }
}

TEST(PriorPlug, TakesWhatOnlyTheLeftCameraSeesForSeedsIfToldTo) {
  Frame frame;
  frame.rig.emplace();
  frame.rig->pair.width = 64;
  frame.rig->pair.height = 48;
  frame.left = cv::Mat(48, 64, CV_8UC1);
  frame.seeds = SeedSet{.seeds = {SeedAt(40, 0, 8), SeedAt(60, 0, 8), SeedAt(40, 47, 8)}, .raw = 3};
  frame.left_seeds = SeedSet{.seeds = {SeedAt(0, 0, 20), SeedAt(0, 47, 20)}, .raw = 2};
  PriorConfig config;
  config.set_method(PriorConfig::DELAUNAY);
  const auto at_the_left = [&](bool left_seeds) {
    config.set_left_seeds(left_seeds);
    PriorPlug plug(config);
    EXPECT_EQ(plug.Inputs().Has(Part::kLeftSeeds), left_seeds);
    return std::get<PriorMap>(plug.Process(frame).outputs[0].value).disparity.Px(0, 24);
  };
  EXPECT_EQ(at_the_left(true), 20);
  EXPECT_EQ(at_the_left(false), 8);
}

TEST(Prior, RefusesSidesForWhichItsNumbersAreTooShort) {
  PriorConfig config;
  config.set_method(PriorConfig::DELAUNAY);
  PriorEstimator estimator(config);
  const std::vector<Seed> seeds = {SeedAt(0, 0, 5), SeedAt(2, 0, 5), SeedAt(1, 16383, 5)};
  const auto map = estimator.Compute({}, {}, seeds, {3, 16384});
  ASSERT_TRUE(map.has_value());
  EXPECT_EQ(map->disparity.CountValid(), 3 * 16384);
  const auto too_long = estimator.Compute({}, {}, seeds, {3, 16385});
  ASSERT_FALSE(too_long.has_value());
  EXPECT_THAT(too_long.error().text, HasSubstr("3x16385: allowed are up to 16384"));
}

}  // namespace
}  // namespace sprout
