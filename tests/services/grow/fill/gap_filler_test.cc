#include "services/grow/fill/gap_filler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

namespace sprout::grow {
namespace {

constexpr int16_t kGap = DisparityImage::kInvalid;

DisparityImage RandomMap(cv::Size size, uint32_t seed, uint32_t gap_per_cent) {
  std::mt19937 random(seed);
  DisparityImage map(size);
  for (int16_t& count : map.counts()) {
    if (random() % 100 >= gap_per_cent) count = static_cast<int16_t>(random() % 2000);
  }
  return map;
}

// One pass, spelled out.
DisparityImage SlowPass(const DisparityImage& map) {
  DisparityImage filled{map.counts().clone()};
  for (int v = 0; v < map.height(); ++v) {
    for (int u = 0; u < map.width(); ++u) {
      if (map.IsValid(u, v)) continue;
      std::vector<int16_t> around;
      for (int y = std::max(v - 2, 0); y <= std::min(v + 2, map.height() - 1); ++y) {
        for (int x = std::max(u - 2, 0); x <= std::min(u + 2, map.width() - 1); ++x) {
          if (map.IsValid(x, y)) around.push_back(map.counts()(y, x));
        }
      }
      std::sort(around.begin(), around.end());
      if (!around.empty()) filled.counts()(v, u) = around[(around.size() - 1) / 2];
    }
  }
  return filled;
}

DisparityImage FillGaps(const DisparityImage& map, GrowConfig::Fill fill,
                        const DisparityImage& prior) {
  return GapFiller().Fill(map, fill, prior);
}

bool Same(const DisparityImage& a, const DisparityImage& b) {
  return a.size() == b.size() && cv::countNonZero(a.counts() != b.counts()) == 0;
}

TEST(GapFiller, TakesTheMedianOfTheWindow) {
  DisparityImage map(cv::Size(5, 5));
  map.counts()(0, 0) = 10;
  map.counts()(4, 4) = 500;
  map.counts()(0, 4) = 20;
  EXPECT_EQ(FillGaps(map, GrowConfig::ONE_PASS, {}).counts()(2, 2), 20);
  map.counts()(4, 0) = 600;  // of 10, 20, 500, 600 the lower middle one
  EXPECT_EQ(FillGaps(map, GrowConfig::ONE_PASS, {}).counts()(2, 2), 20);
}

TEST(GapFiller, OnePassEqualsTheSlowPass) {
  for (uint32_t seed = 0; seed < 10; ++seed) {
    const DisparityImage map = RandomMap({31, 17}, seed, 60 + 4 * seed);
    EXPECT_TRUE(Same(FillGaps(map, GrowConfig::ONE_PASS, {}), SlowPass(map))) << "seed " << seed;
  }
}

TEST(GapFiller, LeavesValidPixelsAndTheGivenMapAlone) {
  const DisparityImage map = RandomMap({31, 17}, 1, 50);
  const cv::Mat1s before = map.counts().clone();
  const DisparityImage filled = FillGaps(map, GrowConfig::ONE_PASS, {});
  for (int v = 0; v < map.height(); ++v) {
    for (int u = 0; u < map.width(); ++u) {
      EXPECT_EQ(map.counts()(v, u), before(v, u));
      if (!map.IsValid(u, v)) continue;
      EXPECT_EQ(filled.counts()(v, u), map.counts()(v, u));
    }
  }
}

TEST(GapFiller, KeepsAnEmptyMapEmpty) {
  const DisparityImage map(cv::Size(9, 9));
  EXPECT_EQ(FillGaps(map, GrowConfig::ONE_PASS, {}).CountValid(), 0);
}

TEST(GapFiller, NoneReturnsTheMap) {
  const DisparityImage map = RandomMap({9, 9}, 2, 50);
  EXPECT_TRUE(Same(FillGaps(map, GrowConfig::NONE, {}), map));
  EXPECT_GT(cv::countNonZero(map.counts() == kGap), 0);
}

TEST(GapFiller, WorksOnOnePixel) {
  DisparityImage map(cv::Size(1, 1));
  EXPECT_EQ(FillGaps(map, GrowConfig::ONE_PASS, {}).CountValid(), 0);
  map.counts()(0, 0) = 7;
  EXPECT_EQ(FillGaps(map, GrowConfig::ONE_PASS, {}).counts()(0, 0), 7);
}

TEST(GapFiller, PriorFillsGapsAndTakesAwaySinglePixels) {
  DisparityImage map(cv::Size(20, 20));
  map.counts().colRange(0, 10) = 320;
  map.counts()(5, 5) = 900;  // alone among others
  DisparityImage prior(map.size());
  prior.counts() = 640;
  const DisparityImage filled = FillGaps(map, GrowConfig::PRIOR, prior);
  EXPECT_EQ(filled.CountValid(), 400);
  EXPECT_EQ(filled.counts()(5, 5), 320);
  EXPECT_EQ(filled.counts()(5, 15), 640);
  EXPECT_EQ(map.CountValid(), 200) << "the given map was changed";
}

TEST(GapFiller, BandsLeaveNoSeams) {
  const DisparityImage prior = RandomMap({31, 205}, 8, 0);
  for (const uint32_t seed : {1u, 2u}) {
    const DisparityImage map = RandomMap(prior.size(), seed, 30);
    cv::Mat1s expected = map.counts().clone();
    prior.counts().copyTo(expected, expected == kGap);
    cv::medianBlur(expected, expected, 5);
    const DisparityImage filled = FillGaps(map, GrowConfig::PRIOR, prior);
    EXPECT_EQ(cv::countNonZero(filled.counts() != expected), 0);
  }
}

TEST(GapFiller, LeavesAResultAloneThatSomebodyHolds) {
  GapFiller filler;
  for (const GrowConfig::Fill fill : {GrowConfig::ONE_PASS, GrowConfig::PRIOR}) {
    const DisparityImage one = RandomMap({31, 45}, 1, 60);
    const DisparityImage other = RandomMap({31, 45}, 2, 60);
    const DisparityImage first = filler.Fill(one, fill, other);
    const DisparityImage second = filler.Fill(other, fill, one);
    EXPECT_TRUE(Same(first, FillGaps(one, fill, other)));
    EXPECT_TRUE(Same(second, FillGaps(other, fill, one)));
  }
}

TEST(GapFiller, AnEmptyPriorFillsNothing) {
  const DisparityImage map(cv::Size(20, 20));
  EXPECT_EQ(FillGaps(map, GrowConfig::PRIOR, DisparityImage()).CountValid(), 0);
  EXPECT_EQ(FillGaps(map, GrowConfig::PRIOR, DisparityImage(map.size())).CountValid(), 0);
}

}  // namespace
}  // namespace sprout::grow
