#include "services/tools/evaluate/rivals/harris_seeds.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <random>

namespace sprout::evaluate {
namespace {

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
