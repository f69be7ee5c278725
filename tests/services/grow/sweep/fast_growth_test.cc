// The fast growth for EPC against the plain one, on every instruction set and with any number of
// threads.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "services/grow/grower.h"
#include "services/grow/paper/plain_growth.h"
#include "tests/common/config/with.h"
#include "tests/common/core/even_prior.h"
#include "tests/common/testing/instruction_sets.h"
#include "tests/services/grow/grow_scenes.h"

namespace sprout::grow {
namespace {

// Both ways to grow. @returns what the fast one gives.
DisparityImage ExpectFastEqualsPlain(const GrowConfig& config, const cv::Mat1b& left,
                                     const cv::Mat1b& right, const std::vector<Seed>& seeds,
                                     const PriorMap& prior) {
  std::vector<Correspondence> rounded;
  for (const Seed& seed : seeds) {
    const Correspondence s{static_cast<int>(std::lround(seed.u)),
                           static_cast<int>(std::lround(seed.v)),
                           static_cast<int>(std::lround(seed.disparity()))};
    if (WindowsFit(s, left.size())) rounded.push_back(s);
  }
  const DisparityImage fast = Grower(config).Compute(left, right, seeds, prior).value();
  ExpectSame(fast, GrowPlainly(MakeGrowthRule(config), {left, right, prior}, rounded));
  return fast;
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
  double sigma_p_px;  // 0.6: two disparities a pixel are left; 4: up to eleven; 8: pixels are open
  int grey_levels;    // 1: ties wherever the prior lies in the middle; 256: few
  uint32_t seed;
  cv::Size image_size;
};

void PrintTo(const GrowCase& grow, std::ostream* out) {
  *out << "sigma_p " << grow.sigma_p_px << ", " << grow.grey_levels << " grey levels, seed "
       << grow.seed;
}

class FastGrowth : public testing::TestWithParam<GrowCase> {};

TEST_P(FastGrowth, GivesThePixelsOfPlainGrowth) {
  const auto& [sigma_p_px, grey_levels, seed, image_size] = GetParam();
  const cv::Size size = image_size;
  const TwoSurfaces scene(size, seed, grey_levels);

  GrowConfig config = EpcConfig();
  config.set_sigma_p_px(sigma_p_px);
  config.set_threshold(0.4);
  const std::vector<Seed> seeds = RandomSeeds(size, 60, 9, seed);
  for (const bool sub_pixel : {false, true}) {
    config.set_sub_pixel(sub_pixel);
    const PriorMap prior = EvenPrior(scene.prior, 1);
    const DisparityImage fast =
        ExpectFastEqualsPlain(config, scene.left, scene.right, seeds, prior);
    EXPECT_GT(fast.CountValid(), 50);
  }
}

std::vector<GrowCase> AllCases() {
  std::vector<GrowCase> cases;
  for (const double sigma_p_px : {8.0, 4.0, 0.6}) {
    for (const int levels : {1, 2, 3, 256}) {
      for (uint32_t seed = 0; seed < 5; ++seed) {
        cases.push_back({sigma_p_px, levels, seed, {37, 23}});
      }
      cases.push_back({sigma_p_px, levels, 5, {83, 203}});  // four bands
      cases.push_back({sigma_p_px, levels, 6, {60, 64}});   // one band, exactly
      cases.push_back({sigma_p_px, levels, 7, {44, 67}});   // the second has no window
    }
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Random, FastGrowth, testing::ValuesIn(AllCases()));

// A prior that is sure of most pixels, of some less, and of others hardly.
TEST(Grower, GivesThePixelsOfPlainGrowthWherePixelsDifferInHowSureThePriorIs) {
  for (uint32_t seed = 0; seed < 6; ++seed) {
    const cv::Size size(83, 203);
    const TwoSurfaces scene(size, seed, seed % 2 == 0 ? 256 : 3);
    PriorMap prior = EvenPrior(scene.prior, 0.1);
    cv::RNG random(seed);
    cv::Mat1b unsure = prior.sigma.rowRange(0, size.height / (seed < 3 ? 2 : 1));
    for (int i = 0; i < 40; ++i) {
      const cv::Rect patch(random.uniform(0, 70), random.uniform(0, unsure.rows - 12), 12, 9);
      unsure(patch & cv::Rect({}, unsure.size())) = SigmaToCounts(random.uniform(0.3, 4.0));
    }
    prior.sigma.setTo(kMaxSigmaCounts, scene.prior.counts() == DisparityImage::kInvalid);
    GrowConfig config;
    config.set_sigma_s_squared(0.1);
    const std::vector<Seed> seeds = RandomSeeds(size, 60, 9, seed);
    for (const bool sub_pixel : {false, true}) {
      config.set_sub_pixel(sub_pixel);
      const DisparityImage fast =
          ExpectFastEqualsPlain(config, scene.left, scene.right, seeds, prior);
      EXPECT_GT(fast.CountValid(), 1000);
    }
  }
}

// The next larger one would be negative in a map's 16 bits.
TEST(Grower, MatchesNothingBeyondTheLargestDisparityOfAMap) {
  const cv::Size size(1300, 40);
  const cv::Mat1b left = Noise(size, 3, 256);
  const PriorMap prior = ConstantPrior(size, 1023.4);
  for (const int disparity : {DisparityImage::kMaxWholePx, DisparityImage::kMaxWholePx + 1}) {
    std::vector<Seed> seeds;
    for (int v = 5; v < 35; v += 5) {
      seeds.push_back(
          {.u = 1200, .v = static_cast<float>(v), .u_right = static_cast<float>(1200 - disparity)});
    }
    for (const double sigma_p_px : {0.6, 1.5, 8.0}) {
      GrowConfig config = EpcConfig();
      config.set_sigma_p_px(sigma_p_px);
      config.set_sub_pixel(true);
      const DisparityImage map =
          ExpectFastEqualsPlain(config, left, ShiftedBy(left, disparity), seeds, prior);
      EXPECT_GT(map.CountValid(), disparity == DisparityImage::kMaxWholePx ? 5000 : -1);
      for (const int16_t counts : map.counts()) {
        ASSERT_TRUE(counts == DisparityImage::kInvalid || counts > 32 * 1000) << counts;
      }
    }
  }
}

// Seeds at every 10th pixel of its ground truth, and the prior that these give when they are
// enlarged.
TEST(Grower, GivesThePixelsOfPlainGrowthOnAFullScene) {
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
    config.set_sub_pixel(sigma_p_px < 1);
    const PriorMap even = EvenPrior(FromPx(prior), 1);
    const DisparityImage fast = ExpectFastEqualsPlain(config, left, right, seeds, even);
    EXPECT_GT(fast.CountValid(), left.size().area() / 2);
  }
}

// A real scene that every machine has, OpenCV's Aloe: every 12th pixel of the truth as a seed, the
// prior that of the next one and the less sure the farther away it is: open from 6 px on.
TEST(Grower, GivesThePixelsOfPlainGrowthOnAloe) {
  const std::string folder = "/usr/share/doc/opencv-doc/examples/data/";
  const cv::Mat1b left = cv::imread(folder + "aloeL.jpg", cv::IMREAD_REDUCED_GRAYSCALE_2);
  const cv::Mat1b right = cv::imread(folder + "aloeR.jpg", cv::IMREAD_REDUCED_GRAYSCALE_2);
  const cv::Mat1b truth = cv::imread(folder + "aloeGT.png", cv::IMREAD_GRAYSCALE);
  if (left.empty() || right.empty() || truth.empty()) {
    GTEST_SKIP() << "no " << folder << " (opencv-doc)";
  }
  std::vector<Seed> seeds;
  for (int v = 6; v < left.rows; v += 12) {
    for (int u = 6; u < left.cols; u += 12) {
      const float d = std::round(static_cast<float>(truth(2 * v, 2 * u)) / 2);  // of half the size
      const auto left_u = static_cast<float>(u);
      if (d > 0 && d <= left_u) seeds.push_back({left_u, static_cast<float>(v), left_u - d});
    }
  }
  ASSERT_GT(seeds.size(), 500U);

  cv::Mat1b no_seed(left.size(), uint8_t{1});
  for (const Seed& seed : seeds) no_seed(cvRound(seed.v), cvRound(seed.u)) = 0;
  cv::Mat1f distance_px;
  cv::Mat1i label;
  cv::distanceTransform(no_seed, distance_px, label, cv::DIST_L2, cv::DIST_MASK_5,
                        cv::DIST_LABEL_PIXEL);
  std::map<int, int16_t> counts_of;
  for (const Seed& seed : seeds) {
    counts_of[label(cvRound(seed.v), cvRound(seed.u))] = ToCounts(seed.disparity());
  }
  PriorMap prior(left.size());
  for (int v = 0; v < left.rows; ++v) {
    for (int u = 0; u < left.cols; ++u) {
      prior.disparity.counts()(v, u) = counts_of.at(label(v, u));
      prior.sigma(v, u) = SigmaToCounts(distance_px(v, u) / 4);
    }
  }
  const DisparityImage fast = ExpectFastEqualsPlain(GrowConfig(), left, right, seeds, prior);
  EXPECT_GT(fast.CountValid(), left.size().area() / 2);
}

TEST(Grower, GivesTheSameBytesWithEveryInstructionSetAndNumberOfThreads) {
  const cv::Size size(131, 330);
  const TwoSurfaces scene(size, 3, 5);
  const std::vector<Seed> seeds = RandomSeeds(size, 300, 9, 3);
  const std::pair<GrowConfig::Similarity, double> similarities[] = {
      {GrowConfig::MNCC, 1}, {GrowConfig::EXPSSD, 1}, {GrowConfig::EPC, 2}, {GrowConfig::EPC, 0.6}};
  for (const auto& [similarity, sigma_p_px] : similarities) {
    auto config =
        With<GrowConfig>("sigma_p_noise: 0 sigma_s_squared: 0.1 threshold: 0.3 sub_pixel: true");
    config.set_similarity(similarity);
    config.set_sigma_p_px(sigma_p_px);
    const auto expected =
        Grower(config).Compute(scene.left, scene.right, seeds, EvenPrior(scene.prior, 1));
    ASSERT_GT(expected->CountValid(), 1000);
    ForEachInstructionSet([&](const std::string& name) {
      for (const int threads : {1, 2, 3, 8}) {
        SCOPED_TRACE(name + ", threads: " + std::to_string(threads));
        cv::setNumThreads(threads);
        Grower grower(config);
        ExpectSame(*grower.Compute(scene.left, scene.right, seeds, EvenPrior(scene.prior, 1)),
                   *expected);
      }
    });
    cv::setNumThreads(-1);
  }
}

}  // namespace
}  // namespace sprout::grow
