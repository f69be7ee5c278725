#include "services/grow/confidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "tests/common/testing/instruction_sets.h"
#include "tests/services/grow/grow_scenes.h"
#include "tests/services/grow/plain_confidence.h"

namespace sprout::grow {
namespace {

constexpr double kSigmaSSquared = 0.1;
const cv::Size kSize(80, 60);

cv::Mat1b TexturedImage() {
  std::mt19937 random(3);
  cv::Mat1b image(kSize);
  for (uint8_t& value : image) value = static_cast<uint8_t>(64 + random() % 128);
  return image;
}

// Seeds on every fifth pixel of every fifth row.
std::vector<Seed> Grid() {
  std::vector<Seed> seeds;
  for (int v = 2; v < kSize.height; v += 5) {
    for (int u = 2; u < kSize.width; u += 5) {
      seeds.push_back({.u = static_cast<float>(u), .v = static_cast<float>(v), .u_right = 0});
    }
  }
  return seeds;
}

// A surface at 4 px, in front of it from column 40 on another at 10 px.
struct SurfacesOfTexture {
  cv::Mat1b left = TexturedImage();
  cv::Mat1b right = cv::Mat1b(kSize, uint8_t{0});
  DisparityImage map{kSize};

  SurfacesOfTexture() {
    map.counts().colRange(0, 40) = ToCounts(4);
    map.counts().colRange(40, 80) = ToCounts(10);
    for (int v = 0; v < kSize.height; ++v) {
      for (int u = 0; u < kSize.width; ++u) {
        const int u_right = u - (u < 40 ? 4 : 10);
        if (u_right >= 0) right(v, u_right) = left(v, u);
      }
    }
  }
  cv::Mat1b Judge(const DisparityImage& grown, std::span<const Seed> seeds = Grid()) const {
    return ConfidenceEstimator(kSigmaSSquared).Compute(left, right, seeds, grown, map);
  }
};

TEST(Confidence, RisesWithTheDistanceFromDepthEdges) {
  const SurfacesOfTexture scene;
  const cv::Mat1b confidence = scene.Judge(scene.map);
  EXPECT_LT(confidence(30, 40), 145);
  for (int u = 42; u < 62; ++u) EXPECT_LE(confidence(30, u), confidence(30, u + 1)) << u;
  EXPECT_GT(confidence(30, 75), 245);
}

TEST(Confidence, IsLowerWhereGrowthDidNotReach) {
  const SurfacesOfTexture scene;
  DisparityImage grown(scene.map.counts().clone());
  grown.counts()(cv::Rect(60, 20, 12, 12)) = DisparityImage::kInvalid;
  const int without_gap = scene.Judge(scene.map)(26, 66);
  EXPECT_NEAR(scene.Judge(grown)(26, 66), without_gap - 0.15 * 255, 1);
}

TEST(Confidence, IsLowerWhereTheImagesDoNotFit) {
  SurfacesOfTexture scene;
  const int fits = scene.Judge(scene.map)(30, 70);
  scene.right(cv::Rect(50, 20, 20, 20)) = 0;
  EXPECT_NEAR(scene.Judge(scene.map)(30, 70), fits - 0.15 * 255, 1);
}

TEST(Confidence, IsLowerInHolesBetweenTheSeeds) {
  const SurfacesOfTexture scene;
  std::vector<Seed> seeds = Grid();
  seeds.push_back({.u = -7, .v = 1e9, .u_right = 0});  // not in the image
  const cv::Mat1b without = scene.Judge(scene.map);
  EXPECT_EQ(cv::countNonZero(scene.Judge(scene.map, seeds) != without), 0);
  std::erase_if(seeds, [](const Seed& seed) { return seed.u > 50 && seed.v > 20 && seed.v < 50; });
  const cv::Mat1b with_hole = scene.Judge(scene.map, seeds);
  EXPECT_EQ(with_hole(5, 20), without(5, 20));
  EXPECT_NEAR(with_hole(35, 70), without(35, 70) - 0.25 * 255, 1);
  // Between: the next seed, at (72, 17), is 6 px away.
  const double spacing_px = std::sqrt(kSize.area() / static_cast<double>(seeds.size() - 1));
  EXPECT_NEAR(with_hole(23, 72), without(23, 72) - 0.25 * 255 * (6 / spacing_px - 0.75), 4);
}

TEST(Confidence, IsLowerEverywhereWithoutSeeds) {
  const SurfacesOfTexture scene;
  const cv::Mat1b with = scene.Judge(scene.map);
  const cv::Mat1b without = scene.Judge(scene.map, std::span<const Seed>());
  for (int u = 45; u < 80; ++u) EXPECT_NEAR(without(30, u), with(30, u) - 0.25 * 255, 1) << u;
}

TEST(Confidence, IsNothingWithoutADisparity) {
  SurfacesOfTexture scene;
  scene.map.counts()(cv::Rect(10, 10, 5, 5)) = DisparityImage::kInvalid;
  const cv::Mat1b confidence = scene.Judge(scene.map);
  EXPECT_EQ(cv::countNonZero(confidence(cv::Rect(10, 10, 5, 5))), 0);
  EXPECT_GT(confidence(30, 75), 0);
}

TEST(Confidence, TakesBlackImages) {
  const cv::Mat1b black(kSize, uint8_t{0});
  const DisparityImage map(cv::Mat1s(kSize, ToCounts(2)));
  const cv::Mat1b confidence =
      ConfidenceEstimator(kSigmaSSquared).Compute(black, black, Grid(), map, map);
  EXPECT_EQ(confidence(30, 40), 255);
}

// Surfaces with edges and gaps, some of their disparities out of the image or below zero.
DisparityImage Patches(cv::Size size, cv::RNG& random) {
  DisparityImage map(size);
  map.counts() = static_cast<int16_t>(random.uniform(-100, 600));
  for (int i = 0; i < 12; ++i) {
    const cv::Rect patch(random.uniform(0, size.width), random.uniform(0, size.height),
                         random.uniform(1, 60), random.uniform(1, 40));
    map.counts()(patch & cv::Rect({}, size)) = static_cast<int16_t>(random.uniform(-3000, 3000));
  }
  for (int i = 0; i < size.area() / 20; ++i) {
    map.counts()(random.uniform(0, size.height), random.uniform(0, size.width)) =
        random.uniform(0, 3) == 0 ? DisparityImage::kInvalid
                                  : static_cast<int16_t>(random.uniform(-200, 2000));
  }
  return map;
}

TEST(Confidence, GivesTheBytesOfThePlainOneWithEveryInstructionSetAndNumberOfThreads) {
  cv::RNG random(5);
  for (const cv::Size size :
       {cv::Size(5, 5), {37, 9}, {131, 70}, {64, 203}, {250, 32}, {33, 33}, {200, 129}}) {
    const cv::Mat1b left = Noise(size, 1, 256);
    const cv::Mat1b right = Noise(size, 2, 256);
    const DisparityImage filled = Patches(size, random);
    const DisparityImage grown = Patches(size, random);
    for (const int count : {0, 1, 40}) {
      const std::vector<Seed> seeds = RandomSeeds(size, count, 9, 3);
      const cv::Mat1b plain = PlainConfidence(left, right, seeds, grown, filled, kSigmaSSquared);
      ForEachInstructionSet([&](const std::string& name) {
        for (const int threads : {1, 2, 8}) {
          cv::setNumThreads(threads);
          ConfidenceEstimator fast(kSigmaSSquared);
          for (const char* run : {"first", "second"}) {
            const cv::Mat1b confidence = fast.Compute(left, right, seeds, grown, filled);
            EXPECT_EQ(cv::countNonZero(confidence != plain), 0)
                << name << ", threads " << threads << ", " << size << ", seeds " << count << ", "
                << run;
          }
        }
      });
      cv::setNumThreads(-1);
    }
  }
}

}  // namespace
}  // namespace sprout::grow
