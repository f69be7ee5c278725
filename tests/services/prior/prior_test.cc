// The stage and its adapter.
#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "services/prior/prior_adapter.h"
#include "services/prior/prior_estimator.h"
#include "tests/common/core/centred.h"

namespace sprout::prior {
namespace {

using testing::HasSubstr;

Seed SeedAt(double u, double v, double disparity) {
  const auto left = static_cast<float>(u);
  return {.u = left, .v = static_cast<float>(v), .u_right = left - static_cast<float>(disparity)};
}

PriorConfig Delaunay() {
  PriorConfig config;
  config.set_method(PriorConfig::DELAUNAY);
  return config;
}

TEST(Prior, TakesTheFirstOfSeedsOnOnePosition) {
  const std::vector<Seed> seeds = {SeedAt(10, 10, 5), SeedAt(50, 10, 5), SeedAt(10, 40, 5),
                                   SeedAt(10, 10, 50)};
  const auto prior = PriorEstimator(Delaunay()).Compute({}, {}, seeds, {64, 48});
  EXPECT_EQ(prior->disparity.Px(12, 12), 5);
}

TEST(Prior, SaysWhyThereIsNone) {
  const auto error = [](const std::vector<Seed>& seeds) {
    return PriorEstimator(Delaunay()).Compute({}, {}, seeds, {64, 48}).error().text;
  };
  EXPECT_THAT(error({}), HasSubstr("0 seeds"));
  EXPECT_THAT(error({SeedAt(1, 1, 1)}), HasSubstr("1 seeds"));
  EXPECT_THAT(error({SeedAt(1, 1, 1), SeedAt(9, 1, 1)}), HasSubstr("at least 3"));
  EXPECT_THAT(error({SeedAt(1, 1, 1), SeedAt(9, 9, 1), SeedAt(20, 20, 1)}),
              HasSubstr("on one line"));
}

TEST(Prior, SaysHowSureItIsBetweenItsSeedsAndThatItKnowsNothingBeyond) {
  std::vector<Seed> seeds = {SeedAt(10, 10, 5), SeedAt(50, 10, 5), SeedAt(30, 40, 5)};
  for (Seed& seed : seeds) seed.sigma_px = 0.75;
  const PriorMap prior = PriorEstimator(Delaunay()).Compute({}, {}, seeds, {64, 48}).value();
  EXPECT_EQ(prior.sigma(20, 30), SigmaToCounts(0.75));
  EXPECT_EQ(prior.sigma(45, 2), kMaxSigmaCounts);
}

TEST(Prior, RefusesSidesForWhichItsNumbersAreTooShort) {
  PriorEstimator estimator(Delaunay());
  const std::vector<Seed> seeds = {SeedAt(0, 0, 5), SeedAt(2, 0, 5), SeedAt(1, 16383, 5)};
  const auto map = estimator.Compute({}, {}, seeds, {3, 16384}).value();
  EXPECT_EQ(map.disparity.CountValid(), 3 * 16384);
  const auto too_long = estimator.Compute({}, {}, seeds, {3, 16385});
  ASSERT_FALSE(too_long.has_value());
  EXPECT_THAT(too_long.error().text, HasSubstr("3x16385: allowed are up to 16384"));
}

constexpr int kNear = 20;
constexpr int kFar = 8;

// A near square on a far wall, both textured, in two colour_term; the edge lies between seeds.
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
            .Compute(cv::Mat3b(size, cv::Vec3b()), cv::Mat1b(size, uint8_t{0}), seeds, size)
            .value();
    EXPECT_EQ(prior.disparity.CountValid(), static_cast<int64_t>(size.area()));
  }
}

TEST(Edges, SayWhyThereIsNoneAndGoOn) {
  const Step step;
  PriorEstimator estimator{PriorConfig()};
  EXPECT_FALSE(estimator.Compute(step.left, step.right, {}, step.size).has_value());
  EXPECT_TRUE(AreSame(estimator.Compute(step.left, step.right, step.Seeds(), step.size)->disparity,
                      PriorBy(PriorConfig::EDGES, step, step.Seeds())));
}

// A frame of 64×48 px that has these seeds.
Frame FrameWith(const std::vector<Seed>& seeds) {
  Frame frame;
  frame.rig.emplace();
  frame.rig->pair.width = 64;
  frame.rig->pair.height = 48;
  frame.left = frame.right = cv::Mat(48, 64, CV_8UC1, cv::Scalar(7));
  frame.seeds = SeedSet{.seeds = seeds, .raw = static_cast<int>(seeds.size())};
  frame.left_seeds = SeedSet();
  return frame;
}

TEST(PriorAdapter, TakesFarPointsWithNegativeDisparitiesInTheWidestImages) {
  Frame frame = FrameWith({SeedAt(9, 0, -5), SeedAt(16000, 0, -5), SeedAt(100, 3, -5)});
  frame.rig->pair = CentredPair(16384, 4, 16000);
  frame.rig->pair.cx_right = 8197;
  frame.left = frame.right = cv::Mat(4, 16384, CV_8UC1, cv::Scalar(7));
  const StageResult outcome = PriorAdapter(Delaunay()).Process(frame);
  EXPECT_EQ(outcome.degenerate, "");
  EXPECT_GT(std::get<PriorMap>(outcome.outputs[0].value).disparity.CountValid(), 4 * 15000);
}

TEST(PriorAdapter, AnswersADegenerateFrameWithAnEmptyMap) {
  const StageResult outcome = PriorAdapter(Delaunay()).Process(FrameWith({SeedAt(1, 1, 1)}));
  EXPECT_THAT(outcome.degenerate, HasSubstr("at least 3"));
  ASSERT_EQ(outcome.outputs.size(), 1u);
  EXPECT_EQ(outcome.outputs[0].part, Part::kPrior);
  const auto& map = std::get<PriorMap>(outcome.outputs[0].value);
  EXPECT_EQ(map.size(), cv::Size(64, 48));
  EXPECT_EQ(map.disparity.CountValid(), 0);
}

TEST(PriorAdapter, AnswersWithTheSizeOfTheImagesWhateverTheCalibrationClaims) {
  Frame frame = FrameWith({SeedAt(0, 0, 5), SeedAt(9, 0, 5), SeedAt(1, 9, 5)});
  frame.rig->pair.width = frame.rig->pair.height = 10000;
  for (const auto method : {PriorConfig::DELAUNAY, PriorConfig::EDGES}) {
    PriorConfig config;
    config.set_method(method);
    PriorAdapter adapter(config);
    EXPECT_TRUE(adapter.Inputs().Has(Part::kLeft));
    const StageResult outcome = adapter.Process(frame);
    EXPECT_THAT(outcome.degenerate, HasSubstr("64x48: allowed is the calibrated size 10000x10000"));
    EXPECT_EQ(std::get<PriorMap>(outcome.outputs[0].value).size(), cv::Size(64, 48));
  }
}

TEST(PriorAdapter, TakesWhatOnlyTheLeftCameraSeesForSeedsIfToldTo) {
  Frame frame = FrameWith({SeedAt(40, 0, 8), SeedAt(60, 0, 8), SeedAt(40, 47, 8)});
  frame.left_seeds = SeedSet{.seeds = {SeedAt(0, 0, 20), SeedAt(0, 47, 20)}, .raw = 2};
  PriorConfig config = Delaunay();
  const auto at_the_left = [&](bool left_seeds) {
    config.set_left_seeds(left_seeds);
    PriorAdapter adapter(config);
    EXPECT_EQ(adapter.Inputs().Has(Part::kLeftSeeds), left_seeds);
    return std::get<PriorMap>(adapter.Process(frame).outputs[0].value).disparity.Px(0, 24);
  };
  EXPECT_EQ(at_the_left(true), 20);
  EXPECT_EQ(at_the_left(false), 8);
}

Seed OutlineSeed(float u, float v) { return {.u = u, .v = v, .u_right = u - 5}; }

double AreaOf(const std::vector<Seed>& seeds, const std::vector<SeedTriangle>& triangles) {
  double area = 0;
  for (const auto& [i, j, k] : triangles) {
    const Seed &a = seeds[static_cast<size_t>(i)], &b = seeds[static_cast<size_t>(j)],
               &c = seeds[static_cast<size_t>(k)];
    area += std::abs((double{b.u} - a.u) * (double{c.v} - a.v) -
                     (double{b.v} - a.v) * (double{c.u} - a.u)) /
            2;
  }
  return area;
}

// Of a closed line of seeds.
double AreaIn(const std::vector<Seed>& seeds, const std::vector<int>& outline) {
  double twice = 0;
  for (size_t i = 0; i < outline.size(); ++i) {
    const Seed& a = seeds[static_cast<size_t>(outline[i])];
    const Seed& b = seeds[static_cast<size_t>(outline[(i + 1) % outline.size()])];
    twice += double{a.u} * b.v - double{b.u} * a.v;
  }
  return std::abs(twice) / 2;
}

// 12 × 5 seeds 10 px apart, the rows downwards from v = 20.
std::vector<Seed> TwelveByFive() {
  std::vector<Seed> seeds;
  for (int i = 0; i < 60; ++i) {
    seeds.push_back(
        OutlineSeed(static_cast<float>(10 * (i % 12)), static_cast<float>(20 + 10 * (i / 12))));
  }
  return seeds;
}

TEST(Outline, LeadsAlongARowThatASeedFurtherOutSpans) {
  std::vector<Seed> seeds = TwelveByFive();
  const Triangulation grid = Triangulate(seeds);
  seeds.push_back(OutlineSeed(0, 16));
  seeds.push_back(OutlineSeed(110, 16));
  const Triangulation before = Triangulate(seeds);
  Triangulation after = before;
  RemoveFlatTriangles(seeds, 15, 10, after);
  // The hull led from one of the two to the other. Now all of the first row lie on the outline.
  EXPECT_EQ(before.hull.size(), grid.hull.size() + 2 - 10);
  EXPECT_EQ(after.hull.size(), grid.hull.size() + 2);
  for (int i = 0; i < 12; ++i) EXPECT_THAT(after.hull, testing::Contains(i));
  // What was between it and that side is gone: the two triangles beside the ends stay.
  EXPECT_DOUBLE_EQ(AreaOf(seeds, before.triangles), 110 * 44);
  EXPECT_DOUBLE_EQ(AreaOf(seeds, after.triangles), 110 * 40 + 2 * (10 * 4 / 2));
  EXPECT_DOUBLE_EQ(AreaIn(seeds, after.hull), AreaOf(seeds, after.triangles));
  EXPECT_EQ(before.neighbours, after.neighbours);
}

TEST(Outline, StaysWhereSidesAreShortOrTrianglesDeep) {
  std::vector<Seed> seeds = TwelveByFive();
  seeds.push_back(OutlineSeed(0, 16));
  seeds.push_back(OutlineSeed(110, 16));
  const Triangulation before = Triangulate(seeds);
  for (const auto& [max_side_px, max_depth_px] : {std::pair(111.0, 10.0), {30.0, 3.9}}) {
    Triangulation after = before;
    RemoveFlatTriangles(seeds, max_side_px, max_depth_px, after);
    EXPECT_EQ(after.hull, before.hull);
    EXPECT_EQ(after.triangles, before.triangles);
  }
  Triangulation none;
  RemoveFlatTriangles({}, 30, 10, none);
  EXPECT_TRUE(none.hull.empty());
}

TEST(Outline, HoldsEverySeedOnceAndAllTrianglesThatAreLeft) {
  std::vector<Seed> seeds;
  uint32_t random = 1;
  for (int i = 0; i < 500; ++i) {
    const auto next = [&] {
      return static_cast<float>((random = random * 1664525 + 1013904223) >> 16);
    };
    const float u = next();
    seeds.push_back(OutlineSeed(u / 100, next() / 400));
  }
  const Triangulation before = Triangulate(seeds);
  Triangulation after = before;
  RemoveFlatTriangles(seeds, 20, 15, after);
  EXPECT_GT(after.hull.size(), before.hull.size() + 10);
  std::vector<int> sorted = after.hull;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(std::adjacent_find(sorted.begin(), sorted.end()), sorted.end());
  EXPECT_EQ(before.triangles.size() - after.triangles.size(),
            after.hull.size() - before.hull.size());
  EXPECT_NEAR(AreaIn(seeds, after.hull), AreaOf(seeds, after.triangles), 1e-6 * 655 * 163);
}

}  // namespace
}  // namespace sprout::prior
