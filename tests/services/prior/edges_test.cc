#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "services/prior/prior_estimator.h"
#include "services/prior/seed_spreading.h"
#include "services/prior/seed_surface.h"

namespace sprout {
namespace {

constexpr int kNear = 20;
constexpr int kFar = 8;

// A near square on a far wall, both textured, in two colours; the edge lies between seeds.
struct Step {
  cv::Size size{160, 120};
  cv::Rect square{53, 33, 54, 54};
  cv::Mat3b left{size};
  cv::Mat1b right{size, uint8_t{0}};

  Step() {
    std::mt19937 random(1);
    cv::Mat1b grey(size);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const auto texture = static_cast<uint8_t>(random() % 60);
        const bool near = square.contains({u, v});
        left(v, u) = near ? cv::Vec3b(texture, texture, 180 + texture)
                          : cv::Vec3b(120 + texture, texture, texture);
      }
    }
    cv::cvtColor(left, grey, cv::COLOR_BGR2GRAY);
    for (const int disparity : {kFar, kNear}) {  // the near one hides the far one
      for (int v = 0; v < size.height; ++v) {
        for (int u = disparity; u < size.width; ++u) {
          if (Truth(u, v) == disparity) right(v, u - disparity) = grey(v, u);
        }
      }
    }
  }

  int Truth(int u, int v) const { return square.contains({u, v}) ? kNear : kFar; }

  std::vector<Seed> Seeds(double noise_px = 0) const {
    std::mt19937 random(2);
    std::normal_distribution<double> normal(0, 1);
    std::vector<Seed> seeds;
    for (int v = 5; v < size.height; v += 10) {
      for (int u = 25; u < size.width; u += 10) {
        const double d = Truth(u, v) + noise_px * normal(random);
        const auto column = static_cast<float>(u);
        seeds.push_back({.u = column,
                         .v = static_cast<float>(v),
                         .u_right = column - static_cast<float>(d),
                         .sigma_px = static_cast<float>(0.05 + noise_px)});
      }
    }
    return seeds;
  }

  // Share of pixels inside the seeds' hull that are within a pixel of the truth.
  double Correct(const DisparityImage& map) const {
    int correct = 0;
    int all = 0;
    for (int v = 5; v < size.height - 5; ++v) {
      for (int u = 25; u < size.width - 5; ++u, ++all) {
        correct += std::abs(map.Px(u, v) - static_cast<float>(Truth(u, v))) < 1;
      }
    }
    return static_cast<double>(correct) / all;
  }
};

DisparityImage PriorBy(PriorConfig::Method method, const Step& step,
                       const std::vector<Seed>& seeds) {
  PriorConfig config;
  config.set_method(method);
  return PriorEstimator(config).Compute(step.left, step.right, seeds, step.size).value().disparity;
}

TEST(Edges, PutTheStepWhereTheImagesHaveIt) {
  const Step step;
  EXPECT_LT(step.Correct(PriorBy(PriorConfig::DELAUNAY, step, step.Seeds())), 0.92);
  EXPECT_GT(step.Correct(PriorBy(PriorConfig::EDGES, step, step.Seeds())), 0.99);
}

TEST(Edges, SmoothNoisySeedsButNotOverTheStep) {
  const Step step;
  const std::vector<Seed> seeds = step.Seeds(1);
  EXPECT_GT(step.Correct(PriorBy(PriorConfig::EDGES, step, seeds)),
            step.Correct(PriorBy(PriorConfig::DELAUNAY, step, seeds)) + 0.1);
}

TEST(Edges, RefuseImagesOfAnotherSize) {
  const Step step;
  const auto prior =
      PriorEstimator(PriorConfig()).Compute(step.left, cv::Mat1b(3, 4), step.Seeds(), step.size);
  EXPECT_THAT(prior.error().text, testing::HasSubstr("4x3"));
}

TEST(Edges, SurviveSeedsOutsideTheImageAndGreyImages) {
  Step step;
  std::vector<Seed> seeds = step.Seeds();
  seeds.push_back({-300, -200, -305});
  seeds.push_back({5000, 60, 4990});
  cv::Mat1b grey;
  cv::cvtColor(step.left, grey, cv::COLOR_BGR2GRAY);
  const auto prior = PriorEstimator(PriorConfig()).Compute(grey, step.right, seeds, step.size);
  EXPECT_EQ(prior->disparity.CountValid(), static_cast<int64_t>(step.size.area()));
}

bool AreSame(const DisparityImage& a, const DisparityImage& b) {
  return cv::countNonZero(a.counts() != b.counts()) == 0;
}

TEST(Edges, GiveTheSameBytesForAnyNumberOfThreadsAndFrameAfterFrame) {
  Step step;
  std::vector<Seed> seeds = step.Seeds(0.3);
  for (const int u : {0, step.size.width - 1}) {
    for (const int v : {0, step.size.height - 1}) {
      seeds.push_back({static_cast<float>(u), static_cast<float>(v), static_cast<float>(u - kFar)});
    }
  }
  const cv::Rect odd(0, 0, step.size.width - 3, step.size.height - 1);
  for (const cv::Rect& part : {cv::Rect({}, step.size), odd}) {
    for (const double noisy_px : {0.1, 100.0}) {
      PriorConfig config;
      config.set_noisy_px(noisy_px);
      PriorEstimator estimator(config);
      const auto compute = [&](int threads) {
        cv::setNumThreads(threads);
        return estimator.Compute(step.left(part), step.right(part), seeds, part.size())
            .value()
            .disparity;
      };
      const DisparityImage expected = compute(1);
      for (const int threads : {1, 2, 3, 8}) {
        EXPECT_TRUE(AreSame(compute(threads), expected)) << threads << " threads";
      }
    }
  }
  cv::setNumThreads(-1);
}

TEST(Edges, SurviveTinyImages) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 1), cv::Size(1, 5), cv::Size(5, 5)}) {
    const std::vector<Seed> seeds = {{-1, -1, -9}, {9, -1, 7}, {-1, 9, -9}, {9, 9, 1}};
    const auto prior =
        PriorEstimator(PriorConfig())
            .Compute(cv::Mat3b(size, cv::Vec3b()), cv::Mat1b(size, uint8_t{0}), seeds, size);
    ASSERT_TRUE(prior.has_value());
    EXPECT_EQ(prior->disparity.CountValid(), static_cast<int64_t>(size.area()));
  }
}

TEST(Edges, SayWhyThereIsNoneAndGoOn) {
  const Step step;
  PriorEstimator estimator{PriorConfig()};
  EXPECT_FALSE(estimator.Compute(step.left, step.right, {}, step.size).has_value());
  EXPECT_TRUE(AreSame(estimator.Compute(step.left, step.right, step.Seeds(), step.size)->disparity,
                      PriorBy(PriorConfig::EDGES, step, step.Seeds())));
}

TEST(Fgs, KeepsToTheColoursAndHasNoGaps) {
  const Step step;
  const DisparityImage prior = PriorBy(PriorConfig::FGS, step, step.Seeds());
  EXPECT_EQ(prior.CountValid(), static_cast<int64_t>(step.size.area()));
  EXPECT_NEAR(prior.Px(80, 60), kNear, 1);
  EXPECT_NEAR(prior.Px(30, 10), kFar, 1);
}

TEST(SeedSpreading, GivesNothingWithoutSeeds) {
  const cv::Mat1f spread = SpreadSeeds({}, cv::Mat3b(8, 9), 10, 3);
  EXPECT_EQ(spread.size(), cv::Size(9, 8));
  EXPECT_TRUE(std::isnan(spread(4, 4)));
}

TEST(SeedSurface, FindsTheSlantAndTheNoise) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1);
  for (const double noise_px : {0.0, 1.5}) {
    std::vector<Seed> seeds;
    for (int v = 0; v < 200; v += 10) {
      for (int u = 0; u < 200; u += 10) {
        const double d = 10 + 0.05 * u - 0.02 * v + noise_px * normal(random);
        seeds.push_back({.u = static_cast<float>(u),
                         .v = static_cast<float>(v),
                         .u_right = static_cast<float>(u - d),
                         .sigma_px = static_cast<float>(0.05 + noise_px)});
      }
    }
    seeds.back().sigma_px = 50;  // one that is worse does not count
    SeedSurfaceFitter fitter;
    const SeedSurface& surface = fitter.Fit(seeds, TriangulateSeeds(seeds), 0.5, 0);
    EXPECT_NEAR(surface.noise_px, 0.05 + noise_px, 1e-6);
    const LocalPlane& plane = surface.planes[10 * 20 + 10];  // at (100, 100)
    EXPECT_NEAR(plane.disparity, 13, 0.01 + noise_px);
    EXPECT_NEAR(plane.At(110, 100) - plane.At(100, 100), 0.5, 0.05 + noise_px / 3);
  }
}

// A slant that is counted in whole pixels looks like stairs, with steps that are three seeds wide.
TEST(SeedSurface, TakesOffTheStepsInWhichDisparitiesAreCounted) {
  constexpr int kSide = 30;  // seeds
  const auto truth = [](float u, float v) { return 20 + 0.03F * u + 0.002F * v; };
  std::vector<Seed> seeds;
  for (int i = 0; i < kSide * kSide; ++i) {
    const auto u = static_cast<float>(10 * (i % kSide));
    const auto v = static_cast<float>(10 * (i / kSide));
    seeds.push_back({u, v, u - std::round(truth(u, v))});
  }
  SeedSurfaceFitter fitter;
  const SeedSurface& surface = fitter.Fit(seeds, TriangulateSeeds(seeds), 0.5, 0.5);
  double counted = 0;
  double smoothed = 0;
  for (size_t i = 0; i < seeds.size(); ++i) {
    const float d = truth(seeds[i].u, seeds[i].v);
    counted += std::abs(seeds[i].disparity() - d);
    smoothed += std::abs(surface.planes[i].disparity - d);
  }
  EXPECT_LT(smoothed, 0.6 * counted);
}

// What differs by more than steps do is another surface.
TEST(SeedSurface, LeavesDepthEdgesAsTheyAre) {
  std::vector<Seed> seeds;
  for (int i = 0; i < 20 * 20; ++i) {
    const auto u = static_cast<float>(10 * (i % 20));
    seeds.push_back({u, static_cast<float>(10 * (i / 20)), u - (u < 95 ? 12 : 15)});
  }
  SeedSurfaceFitter fitter;
  const SeedSurface& surface = fitter.Fit(seeds, TriangulateSeeds(seeds), 0.5, 0.5);
  for (size_t i = 0; i < seeds.size(); ++i) {
    EXPECT_NEAR(surface.planes[i].disparity, seeds[i].disparity(), 0.01);
  }
}

// Steps of a pixel are not taken for an edge, and so nobody asks for a robust fit.
TEST(SeedSurface, HasASlantAwayFromEdgesToo) {
  std::vector<Seed> seeds;
  for (int i = 0; i < 20 * 20; ++i) {
    const auto u = static_cast<float>(10 * (i % 20));
    const auto v = static_cast<float>(10 * (i / 20));
    seeds.push_back({u, v, u - (20 + 0.04F * u)});
  }
  SeedSurfaceFitter fitter;
  const SeedSurface& surface = fitter.Fit(seeds, TriangulateSeeds(seeds), 0.5, 1);
  EXPECT_NEAR(surface.planes[10 * 20 + 10].per_column, 0.04, 0.005);
}

}  // namespace
}  // namespace sprout
