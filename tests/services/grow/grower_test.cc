#include "services/grow/grower.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <set>
#include <vector>

#include "tests/services/grow/slow_growth.h"

namespace sprout {
namespace {

cv::Mat1b Noise(cv::Size size, uint32_t seed, int levels) {
  std::mt19937 random(seed);
  cv::Mat1b image(size);
  for (uint8_t& value : image) {
    value = static_cast<uint8_t>(random() % static_cast<uint32_t>(levels) * 255 /
                                 static_cast<uint32_t>(levels));
  }
  return image;
}

// The right view of a textured scene with disparity `d` everywhere: right(u − d) = left(u).
cv::Mat1b ShiftedBy(const cv::Mat1b& left, int d) {
  cv::Mat1b right(left.size(), uint8_t{0});
  left.colRange(d, left.cols).copyTo(right.colRange(0, left.cols - d));
  return right;
}

DisparityImage ConstantPrior(cv::Size size, double disparity) {
  DisparityImage prior(size);
  prior.counts() = ToCounts(disparity);
  return prior;
}

void ExpectSame(const DisparityImage& fast, const DisparityImage& slow) {
  ASSERT_EQ(fast.size(), slow.size());
  for (int v = 0; v < fast.height(); ++v) {
    for (int u = 0; u < fast.width(); ++u) {
      ASSERT_EQ(fast.counts()(v, u), slow.counts()(v, u)) << "at (" << u << ", " << v << ")";
    }
  }
}

std::vector<Seed> RandomSeeds(cv::Size size, int count, int max_disparity, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Seed> seeds;
  for (int i = 0; i < count; ++i) {
    const auto u = static_cast<float>(random() % static_cast<uint32_t>(size.width));
    const auto v = static_cast<float>(random() % static_cast<uint32_t>(size.height));
    const float d = static_cast<float>(random() % static_cast<uint32_t>(4 * max_disparity)) / 4;
    seeds.push_back({u, v, u - d});
  }
  return seeds;
}

// Two textured surfaces with a step between them, and a prior that is a little off; in places it
// jumps, and asks for what no image has.
struct TwoSurfaces {
  TwoSurfaces(cv::Size size, uint32_t seed, int grey_levels)
      : left(Noise(size, seed, grey_levels)), right(ShiftedBy(left, 4)), prior(size) {
    const int step = size.height * 2 / 5;
    const cv::Range lower(step, size.height);
    ShiftedBy(left, 7).rowRange(lower).copyTo(right.rowRange(lower));
    prior.counts() = ToCounts(4.3);
    prior.counts().rowRange(lower) = ToCounts(6.8);
    std::mt19937 random(seed);
    for (int i = 0; i < size.area() / 8; ++i) {
      const auto pixel = static_cast<int>(random() % static_cast<uint32_t>(size.area()));
      int16_t& counts = prior.counts()(pixel / size.width, pixel % size.width);
      counts = static_cast<int16_t>(counts + static_cast<int>(random() % 64) - 32);
    }
    for (const double px : {-0.5, -1.5, -40.0, 10.0, 20.0, size.width - 5.0, 900.0}) {
      for (int i = 0; i < 8; ++i) {
        const auto pixel = static_cast<int>(random() % static_cast<uint32_t>(size.area()));
        prior.counts()(pixel / size.width, pixel % size.width) = ToCounts(px);
      }
    }
    prior.counts()(size.height / 2, size.width / 3) = DisparityImage::kInvalid;
  }

  cv::Mat1b left;
  cv::Mat1b right;
  DisparityImage prior;
};

struct GrowCase {
  GrowConfig::Similarity similarity;
  double sigma_p_px;  // 0.6: two disparities a pixel are left
  int grey_levels;    // 2: many ties; 256: few
  uint32_t seed;
  cv::Size image_size;
};

class GrowerAgainstSlowGrowth : public testing::TestWithParam<GrowCase> {};

TEST_P(GrowerAgainstSlowGrowth, GivesTheSamePixels) {
  const auto& [similarity, sigma_p_px, grey_levels, seed, image_size] = GetParam();
  const cv::Size size = image_size;
  const TwoSurfaces scene(size, seed, grey_levels);

  GrowConfig config;
  config.set_similarity(similarity);
  config.set_sigma_s_squared(0.1);
  config.set_sigma_p_px(sigma_p_px);
  config.set_sigma_p_noise(0);
  config.set_threshold(0.4);
  const std::vector<Seed> seeds = RandomSeeds(size, 60, 9, seed);
  for (const bool sub_pixel : {false, true}) {
    config.set_sub_pixel(sub_pixel);
    const auto fast = Grower(config).Compute(scene.left, scene.right, seeds, scene.prior);
    ASSERT_TRUE(fast.has_value());
    ExpectSame(*fast, SlowGrow(config, scene.left, scene.right, seeds, scene.prior));
    EXPECT_GT(fast->CountValid(), 50);
  }
}

std::vector<GrowCase> AllCases() {
  std::vector<GrowCase> cases;
  const std::pair<GrowConfig::Similarity, double> similarities[] = {{GrowConfig::MNCC, 1.5},
                                                                    {GrowConfig::EXPSSD, 1.5},
                                                                    {GrowConfig::EPC, 1.5},
                                                                    {GrowConfig::EPC, 0.6}};
  for (const auto& [similarity, sigma_p_px] : similarities) {
    for (const int levels : {2, 3, 256}) {
      for (uint32_t seed = 0; seed < 5; ++seed) {
        cases.push_back({similarity, sigma_p_px, levels, seed, {37, 23}});
      }
      cases.push_back({similarity, sigma_p_px, levels, 5, {83, 203}});  // four bands
      cases.push_back({similarity, sigma_p_px, levels, 6, {60, 64}});   // one band, exactly
      cases.push_back({similarity, sigma_p_px, levels, 7, {44, 67}});   // the second has no window
    }
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Random, GrowerAgainstSlowGrowth, testing::ValuesIn(AllCases()));

GrowConfig EpcConfig() {
  GrowConfig config;
  config.set_similarity(GrowConfig::EPC);
  config.set_sigma_s_squared(0.1);
  config.set_sigma_p_px(2);
  config.set_sigma_p_noise(0);
  config.set_sub_pixel(false);
  return config;
}

// A full-size scene, seeds at every 10th pixel of its ground truth, and the prior that these give
// when they are enlarged.
TEST(Grower, GivesThePixelsOfSlowGrowthOnAFullScene) {
#ifndef NDEBUG
  GTEST_SKIP() << "minutes without optimisation";
#endif
  const char* data = std::getenv("SPROUT_DATA");
  if (data == nullptr) GTEST_SKIP() << "SPROUT_DATA is not set";
  const std::string folder = std::string(data) + "/middlebury/full/Monopoly/";
  const cv::Mat1b left = cv::imread(folder + "view1.png", cv::IMREAD_GRAYSCALE);
  const cv::Mat1b right = cv::imread(folder + "view5.png", cv::IMREAD_GRAYSCALE);
  const cv::Mat1b truth = cv::imread(folder + "disp1.png", cv::IMREAD_GRAYSCALE);
  ASSERT_FALSE(left.empty() || right.empty() || truth.empty()) << folder;

  std::vector<Seed> seeds;
  cv::Mat1f grid(truth.rows / 10, truth.cols / 10);
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.cols; ++i) {
      const cv::Point pixel(10 * i + 5, 10 * j + 5);
      grid(j, i) = truth(pixel);
      if (truth(pixel) == 0) continue;
      seeds.push_back({.u = static_cast<float>(pixel.x),
                       .v = static_cast<float>(pixel.y),
                       .u_right = static_cast<float>(pixel.x - truth(pixel))});
    }
  }
  cv::Mat1f prior;
  cv::resize(grid, prior, truth.size());

  GrowConfig config = EpcConfig();
  for (const double sigma_p_px : {0.7, 17.4}) {
    config.set_sigma_p_px(sigma_p_px);
    const auto fast = Grower(config).Compute(left, right, seeds, FromPx(prior));
    ExpectSame(*fast, SlowGrow(config, left, right, seeds, FromPx(prior)));
    EXPECT_GT(fast->CountValid(), left.size().area() / 2);
  }
}

// Every instruction set that this CPU has, and none.
std::vector<int64_t> InstructionSets() {
  std::vector<int64_t> sets = {HWY_SCALAR};
  for (int64_t all = hwy::SupportedTargets(); all != 0; all &= all - 1) sets.push_back(all & -all);
  return sets;
}

TEST(Grower, GivesTheSameBytesWithEveryInstructionSetAndNumberOfThreads) {
  const cv::Size size(131, 330);
  const TwoSurfaces scene(size, 3, 5);
  const std::vector<Seed> seeds = RandomSeeds(size, 300, 9, 3);
  const std::pair<GrowConfig::Similarity, double> similarities[] = {
      {GrowConfig::MNCC, 1}, {GrowConfig::EXPSSD, 1}, {GrowConfig::EPC, 2}, {GrowConfig::EPC, 0.6}};
  for (const auto& [similarity, sigma_p_px] : similarities) {
    GrowConfig config;
    config.set_similarity(similarity);
    config.set_sigma_p_px(sigma_p_px);
    config.set_sigma_p_noise(0);
    config.set_sigma_s_squared(0.1);
    config.set_threshold(0.3);
    config.set_sub_pixel(true);
    const auto expected = Grower(config).Compute(scene.left, scene.right, seeds, scene.prior);
    ASSERT_GT(expected->CountValid(), 1000);
    for (const int64_t set : InstructionSets()) {
      for (const int threads : {1, 2, 3, 8}) {
        SCOPED_TRACE(std::string(hwy::TargetName(set)) + ", threads: " + std::to_string(threads));
        hwy::SetSupportedTargetsForTest(set);
        hwy::GetChosenTarget().DeInit();  // chosen anew at the next call
        cv::setNumThreads(threads);
        Grower grower(config);
        ExpectSame(*grower.Compute(scene.left, scene.right, seeds, scene.prior), *expected);
      }
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
    cv::setNumThreads(-1);
  }
}

TEST(Grower, GrowsAcrossManyBandsFromOneSeed) {
  const cv::Size size(40, 400);
  const cv::Mat1b left = Noise(size, 1, 256);
  const std::vector<Seed> seeds = {{.u = 20, .v = 390, .u_right = 15}};
  const auto map =
      Grower(EpcConfig()).Compute(left, ShiftedBy(left, 5), seeds, ConstantPrior(size, 5));
  EXPECT_EQ(map->CountValid(), 396 * 31);
}

TEST(Grower, KeepsLessThan30BytesAPixel) {
  const cv::Size size(1000, 640);
  const cv::Mat1b left = Noise(size, 1, 256);
  const std::vector<Seed> seeds = RandomSeeds(size, 6000, 9, 3);
  for (const double sigma_p_px : {0.6, 2.0}) {
    GrowConfig config = EpcConfig();
    config.set_sigma_p_px(sigma_p_px);
    Grower grower(config);
    ASSERT_TRUE(grower.Compute(left, ShiftedBy(left, 5), seeds, ConstantPrior(size, 5)));
    EXPECT_LT(static_cast<double>(grower.scratch_bytes()) / size.area(), 30);
  }
}

TEST(Grower, UsesAMapAgainThatNobodyHolds) {
  const cv::Size size(60, 40);
  const cv::Mat1b left = Noise(size, 6, 4);
  const std::vector<Seed> seeds = RandomSeeds(size, 30, 8, 6);
  const DisparityImage prior = ConstantPrior(size, 3);
  Grower grower(EpcConfig());
  const auto held = grower.Compute(left, ShiftedBy(left, 3), seeds, prior);
  const cv::Mat1s kept = held->counts().clone();
  const uint8_t* memory = grower.Compute(left, left, seeds, prior)->counts().data;
  EXPECT_NE(memory, held->counts().data);
  ExpectSame(*held, DisparityImage(kept));
  EXPECT_EQ(grower.Compute(left, left, seeds, prior)->counts().data, memory);
}

TEST(Grower, CoversATexturedPlaneFromOneSeed) {
  const cv::Size size(60, 40);
  const cv::Mat1b left = Noise(size, 1, 256);
  const std::vector<Seed> seeds = {{.u = 30, .v = 20, .u_right = 25}};
  const auto map =
      Grower(EpcConfig()).Compute(left, ShiftedBy(left, 5), seeds, ConstantPrior(size, 5));
  for (int v = 2; v < 38; ++v) {
    for (int u = 7; u < 58; ++u) EXPECT_EQ(map->Px(u, v), 5) << u << ", " << v;
  }
  // Neither where the left window leaves the image nor where the right one does.
  EXPECT_EQ(map->CountValid(), 36 * 51);
}

TEST(Grower, FollowsASlantOneDisparityAtATime) {
  const cv::Size size(80, 12);
  const cv::Mat1b right = Noise(size, 2, 256);
  cv::Mat1b left(size, uint8_t{0});
  for (int v = 0; v < size.height; ++v) {
    for (int u = 10; u < size.width; ++u) left(v, u) = right(v, u - (9 - u / 10));
  }
  GrowConfig config = EpcConfig();
  config.set_similarity(GrowConfig::EXPSSD);
  config.set_sigma_s_squared(0.2);  // a window across a step passes, a wrong one does not
  const std::vector<Seed> seeds = {{.u = 15, .v = 6, .u_right = 7}};
  const auto map = Grower(config).Compute(left, right, seeds, DisparityImage());
  for (const int u : {25, 35, 45, 55, 65, 75}) EXPECT_EQ(map->Px(u, 6), 9 - u / 10) << u;
}

TEST(Grower, FindsTheSubPixelDisparity) {
  const cv::Size size(120, 60);
  cv::Mat1b fine = Noise({4 * size.width, size.height}, 9, 256);
  cv::GaussianBlur(fine, fine, {}, 8, 2);  // smooth enough for a parabola
  cv::Mat1b left(size);
  cv::Mat1b right(size, uint8_t{0});
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      left(v, u) = fine(v, 4 * u);
      if (u < size.width - 6) right(v, u) = fine(v, 4 * u + 21);  // 5.25 px
    }
  }
  GrowConfig config = EpcConfig();
  config.set_sigma_p_px(1000);
  config.set_sub_pixel(true);
  const std::vector<Seed> seeds = {{.u = 60, .v = 30, .u_right = 55}};
  const auto map = Grower(config).Compute(left, right, seeds, ConstantPrior(size, 5));
  double sum_px = 0;
  int count = 0;
  for (int v = 5; v < 55; ++v) {
    for (int u = 20; u < 100; ++u) {
      if (!map->IsValid(u, v)) continue;
      sum_px += map->Px(u, v);
      ++count;
    }
  }
  EXPECT_GT(count, 50 * 80 * 0.9);
  EXPECT_NEAR(sum_px / count, 5.25, 0.1);
}

TEST(Grower, SigmaPFollowsTheNoiseOfTheSeeds) {
  const cv::Size size(60, 40);
  const cv::Mat1b left = Noise(size, 1, 256);
  GrowConfig config = EpcConfig();
  config.set_sigma_p_px(0.7);
  // The prior is 2 px off: too far for σ_p, unless the seeds are seen to be as bad.
  const std::vector<Seed> seeds = {{30, 20, 25}, {20, 20, 15}, {40, 20, 35}};
  EXPECT_EQ(
      Grower(config).Compute(left, ShiftedBy(left, 5), seeds, ConstantPrior(size, 7))->CountValid(),
      0);
  config.set_sigma_p_noise(2);
  EXPECT_GT(
      Grower(config).Compute(left, ShiftedBy(left, 5), seeds, ConstantPrior(size, 7))->CountValid(),
      1000);
}

TEST(Grower, KeepsOneToOneMatching) {
  const cv::Size size(50, 30);
  const cv::Mat1b flat(size, uint8_t{128});  // every disparity fits everywhere
  GrowConfig config = EpcConfig();
  config.set_sigma_p_px(1000);
  const auto map =
      Grower(config).Compute(flat, flat, RandomSeeds(size, 40, 12, 3), ConstantPrior(size, 5));
  ASSERT_GT(map->CountValid(), 500);
  for (int v = 0; v < size.height; ++v) {
    std::set<int> taken;
    for (int u = 0; u < size.width; ++u) {
      if (!map->IsValid(u, v)) continue;
      const int u_right = u - map->counts()(v, u) / DisparityImage::kCountsPerPixel;
      EXPECT_TRUE(taken.insert(u_right).second) << "right pixel " << u_right << ", row " << v;
      EXPECT_GE(u_right, 2);
    }
  }
}

TEST(Grower, StopsWhereSimilarityFallsBelowTheThreshold) {
  const cv::Size size(60, 30);
  const cv::Mat1b left = Noise(size, 4, 256);
  cv::Mat1b right = ShiftedBy(left, 5);
  Noise({30, 30}, 5, 256).copyTo(right.colRange(30, 60));  // nothing to match from u = 35 on
  const std::vector<Seed> seeds = {{.u = 15, .v = 15, .u_right = 10}};
  const auto map = Grower(EpcConfig()).Compute(left, right, seeds, ConstantPrior(size, 5));
  EXPECT_TRUE(map->IsValid(30, 15));
  EXPECT_LT(cv::countNonZero(map->counts().colRange(38, 60) != DisparityImage::kInvalid), 22);
}

TEST(Grower, GivesTheSameBytesWhenItsQueueIsUsedAgain) {
  const cv::Size size(60, 40);
  const cv::Mat1b left = Noise(size, 6, 4);
  const cv::Mat1b right = ShiftedBy(left, 3);
  const std::vector<Seed> seeds = RandomSeeds(size, 30, 8, 6);
  Grower grower(EpcConfig());
  const auto first = grower.Compute(left, right, seeds, ConstantPrior(size, 3));
  const auto second = grower.Compute(left, right, seeds, ConstantPrior(size, 3));
  ExpectSame(*first, *second);
}

TEST(Grower, IgnoresSeedsWhoseWindowLeavesAnImage) {
  const cv::Size size(40, 30);
  const cv::Mat1b left = Noise(size, 7, 256);
  const std::vector<Seed> seeds = {
      {1, 15, 0}, {10, 15, 9.6f - 9}, {39, 29, 30}, {20, 15, 25}, {-1e4f, 1e4f, 0}};
  const auto map =
      Grower(EpcConfig()).Compute(left, ShiftedBy(left, 5), seeds, ConstantPrior(size, 5));
  EXPECT_EQ(map->CountValid(), 0);
}

TEST(Grower, GivesNothingForNoSeeds) {
  const cv::Mat1b image(30, 40, uint8_t{9});
  const auto map = Grower(EpcConfig()).Compute(image, image, {}, ConstantPrior({40, 30}, 5));
  EXPECT_EQ(map->CountValid(), 0);
}

TEST(Grower, SaysWhatIsWrongWithSizes) {
  const cv::Mat1b image(30, 40, uint8_t{9});
  const cv::Mat1b other(30, 41, uint8_t{9});
  const cv::Mat1b tiny(4, 5, uint8_t{9});
  Grower grower(EpcConfig());
  EXPECT_THAT(grower.Compute(image, other, {}, {}).error().text, testing::HasSubstr("40x30"));
  EXPECT_THAT(grower.Compute(tiny, tiny, {}, DisparityImage(tiny.size())).error().text,
              testing::HasSubstr("smaller than the 5x5 window"));
  EXPECT_THAT(grower.Compute(image, image, {}, DisparityImage(cv::Size(3, 3))).error().text,
              testing::HasSubstr("prior of 3x3"));
}

TEST(Grower, WorksOnImagesOfExactlyOneWindow) {
  const cv::Mat1b image = Noise({5, 5}, 8, 256);
  const std::vector<Seed> seeds = {{2, 2, 2}};
  EXPECT_TRUE(
      Grower(EpcConfig()).Compute(image, image, seeds, ConstantPrior({5, 5}, 0)).has_value());
}

TEST(Grower, RefusesAThresholdOutOfRange) {
  GrowConfig config;
  config.set_threshold(1.5);
  EXPECT_THROW(Grower{config}, ConfigError);
}

}  // namespace
}  // namespace sprout
