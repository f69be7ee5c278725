#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <random>

#include "common/measure/score.h"
#include "services/tools/evaluate/evaluate.h"
#include "services/tools/evaluate/rivals/harris_seeds.h"
#include "services/tools/evaluate/rivals/padded_pair.h"
#include "services/tools/evaluate/rivals/rival.h"

namespace sprout::evaluate {
namespace {

constexpr int kDisparity = 20;

cv::Mat1b Noise(cv::Size size) {
  cv::Mat1b noise(size);
  cv::RNG random(3);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  return noise;
}

// A wall full of texture, straight ahead: what the left camera sees at u the right one sees at
// u − 20.
RivalInput Wall() {
  const cv::Mat1b wall = Noise({260, 80});
  return {.left = wall.colRange(0, 200).clone(),
          .right = wall.colRange(kDisparity, 220).clone(),
          .seeds = {},
          .max_disparity_px = kDisparity};
}

TEST(Rivals, AreNotChargedForTheBorder) {
  const RivalInput input = Wall();
  for (const Rival& rival : AllRivals()) {
    if (rival.uses_seeds) continue;
    const cv::Mat1f map = rival.compute(input);
    ASSERT_EQ(map.size(), input.left.size()) << rival.name;
    // What the right camera sees, right up to its border and to all others. The band that is not
    // searched without padding, 32 columns and more, would be over 15 % of that.
    const cv::Mat1f seen = map.colRange(kDisparity, map.cols);
    const int correct = cv::countNonZero(cv::abs(seen - kDisparity) <= 1);
    EXPECT_GT(correct, 0.94 * static_cast<double>(seen.total())) << rival.name;
  }
}

TEST(PaddedPair, SearchesAMultipleOfSixteenThatCoversTheLargestDisparity) {
  const cv::Mat1b image = Noise({60, 40});
  EXPECT_EQ(PaddedPair(image, image, 0, 5).disparities(), 16);
  EXPECT_EQ(PaddedPair(image, image, 15, 5).disparities(), 16);
  EXPECT_EQ(PaddedPair(image, image, 16, 5).disparities(), 32);
}

TEST(PaddedPair, CropsToWhereTheImagesWere) {
  const cv::Mat1b image = Noise({60, 40});
  for (const PaddedPair::Views views : {PaddedPair::Views::kLeft, PaddedPair::Views::kBoth}) {
    const PaddedPair pair(image, image, 20, 7, views);
    cv::Mat1s counts;
    pair.left().convertTo(counts, CV_16S, 16);  // 16 counts a pixel
    cv::Mat1f expected;
    image.convertTo(expected, CV_32F);
    const cv::Mat1f cropped = pair.Crop(counts);
    ASSERT_EQ(cropped.size(), image.size());
    EXPECT_EQ(cv::countNonZero(cropped != expected), 0);
  }
}

TEST(PaddedPair, TurnsNegativeCountsIntoNoDisparity) {
  const cv::Mat1b image = Noise({60, 40});
  const PaddedPair pair(image, image, 20, 7);
  EXPECT_TRUE(std::isnan(pair.Crop(cv::Mat1s(pair.left().size(), int16_t{-16}))(0, 0)));
}

TEST(Fgs, SpreadsSeedsUpToEdgesOfTheLeftImage) {
  cv::Mat1b left(40, 60, uchar{20});
  left.colRange(30, 60) = 220;
  const std::vector<Seed> seeds = {{.u = 20, .v = 20, .u_right = 15},
                                   {.u = 40, .v = 20, .u_right = 30}};
  const std::vector<Rival> rivals = AllRivals();
  const auto fgs = std::ranges::find(rivals, "fgs", &Rival::name);
  const cv::Mat1f map =
      fgs->compute({.left = left, .right = left, .seeds = seeds, .max_disparity_px = 16});
  EXPECT_NEAR(map(20, 28), 5, 0.1);
  EXPECT_NEAR(map(20, 31), 10, 0.1);
}

// Measured elsewhere on the same data with the same library, one thread: per cent of non-occluded
// pixels with an error <= 1 px (fgs: < 1 px).
TEST(Rivals, LandNearTheirReferenceFiguresOnMonopoly) {
  const char* data = std::getenv("SPROUT_DATA");
  if (data == nullptr) {
    GTEST_SKIP() << "SPROUT_DATA is not set; scripts/fetch_middlebury gets the scenes";
  }
  const Scene scene =
      LoadScene(std::string(data) + "/middlebury/full/Monopoly", TofChoice("grid:auto"), {});
  const auto score = [&](const cv::Mat1f& map) {
    return Score(map, scene.frame.truth.left, scene.nonoccluded).value();
  };
  const auto map_of = [&](const std::string& name) {
    return SelectMethods({name})
        .front()
        .run(scene, {.config = LoadConfig({"paper"}), .noise = {}})
        .map_px;
  };
  constexpr double kPoints = 2;
  EXPECT_NEAR(score(map_of("sgbm-3way")).correct_le1_percent(), 61.9, kPoints);
  EXPECT_NEAR(score(map_of("sgbm-5way")).correct_le1_percent(), 62.5, kPoints);
  EXPECT_NEAR(score(map_of("bm")).correct_le1_percent(), 47.7, kPoints);
  cv::Mat1f fgs = map_of("fgs");
  EXPECT_NEAR(score(fgs).correct_lt1_percent(), 95.53, kPoints);
  for (float& disparity : fgs) disparity = std::round(disparity);
  EXPECT_NEAR(score(fgs).correct_le1_percent(), 98.03, kPoints);
}

cv::Mat1b Squares(cv::Size size, uint32_t seed) {
  std::mt19937 random(seed);
  cv::Mat1b image(size, uint8_t{60});
  for (int i = 0; i < 80; ++i) {
    const cv::Point corner(static_cast<int>(random() % static_cast<uint32_t>(size.width)),
                           static_cast<int>(random() % static_cast<uint32_t>(size.height)));
    cv::rectangle(image, {corner, cv::Size(5 + static_cast<int>(random() % 20), 12)},
                  cv::Scalar(static_cast<double>(random() % 256)), cv::FILLED);
  }
  return image;
}

TEST(HarrisSeeds, MatchesCornersAtTheTrueDisparity) {
  const cv::Mat1b left = Squares({200, 120}, 1);
  cv::Mat1b right(left.size(), uint8_t{0});
  left.colRange(9, 200).copyTo(right.colRange(0, 191));
  const std::vector<Seed> seeds = MatchHarrisCorners(left, right, HarrisSettings());
  ASSERT_GT(seeds.size(), 40u);
  int correct = 0;
  for (const Seed& seed : seeds) correct += seed.disparity() == 9 ? 1 : 0;
  EXPECT_GE(correct, static_cast<int>(seeds.size()) * 95 / 100);
  EXPECT_EQ(CountTofSeeds(seeds), 0);
}

TEST(HarrisSeeds, SearchesNoFurtherThanTheLargestDisparity) {
  const cv::Mat1b left = Squares({200, 120}, 1);
  cv::Mat1b right(left.size(), uint8_t{0});
  left.colRange(9, 200).copyTo(right.colRange(0, 191));
  HarrisSettings config;
  config.max_disparity_px = 8;
  for (const Seed& seed : MatchHarrisCorners(left, right, config)) {
    EXPECT_GE(seed.disparity(), 0);
    EXPECT_LE(seed.disparity(), 8);
  }
}

TEST(HarrisSeeds, FindsNothingInAFlatOrTinyImage) {
  const cv::Mat1b flat(60, 80, uint8_t{100});
  EXPECT_TRUE(MatchHarrisCorners(flat, flat, HarrisSettings()).empty());
  const cv::Mat1b tiny(1, 1, uint8_t{100});
  EXPECT_TRUE(MatchHarrisCorners(tiny, tiny, HarrisSettings()).empty());
}

}  // namespace

}  // namespace sprout::evaluate
