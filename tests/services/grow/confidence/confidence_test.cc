#include "services/grow/confidence/confidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "tests/common/testing/instruction_sets.h"
#include "tests/services/grow/grow_scenes.h"

namespace sprout::grow {
namespace {

const cv::Size kSize(80, 60);

cv::Mat1b TexturedImage() {
  std::mt19937 random(3);
  cv::Mat1b image(kSize);
  for (uint8_t& value : image) value = static_cast<uint8_t>(64 + random() % 128);
  return image;
}

// ToF seeds on every fifth pixel of every fifth row.
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
struct JudgedScene {
  cv::Mat1b left = TexturedImage();
  cv::Mat1b right = cv::Mat1b(kSize, uint8_t{0});
  DisparityImage map{kSize};
  cv::Mat1b sigma_prior = cv::Mat1b(kSize, uint8_t{60});
  DisparityImage grown{kSize};
  std::vector<Seed> seeds = Grid();

  JudgedScene() {
    map.counts().colRange(0, 40) = ToCounts(4);
    map.counts().colRange(40, 80) = ToCounts(10);
    map.counts().copyTo(grown.counts());
    for (int v = 0; v < kSize.height; ++v) {
      for (int u = 0; u < kSize.width; ++u) {
        const int u_right = u - (u < 40 ? 4 : 10);
        if (u_right >= 0) right(v, u_right) = left(v, u);
      }
    }
  }
  ConfidenceEstimator::Judgement Judge() const {
    return ConfidenceEstimator().Compute({left, right, seeds, sigma_prior, grown, map});
  }
};

// A pixel of the second judgement is less sure, and not claimed to be more accurate.
void ExpectLessSure(const ConfidenceEstimator::Judgement& before,
                    const ConfidenceEstimator::Judgement& after, cv::Point at) {
  EXPECT_LT(after.confidence(at), before.confidence(at));
  EXPECT_GE(after.sigma(at), before.sigma(at));
}

TEST(Confidence, RisesWithTheDistanceFromDepthEdges) {
  const auto judged = JudgedScene().Judge();
  EXPECT_LT(judged.confidence(30, 40), judged.confidence(30, 70));
  for (int u = 46; u < 64; ++u) {
    EXPECT_LE(judged.confidence(30, u), judged.confidence(30, u + 1)) << u;
  }
  EXPECT_GT(judged.confidence(30, 70), 200);
  EXPECT_GT(judged.sigma(30, 40), judged.sigma(30, 70));
}

TEST(Confidence, IsLowerWhereTheImagesDoNotFit) {
  JudgedScene scene;
  const auto fits = scene.Judge();
  scene.right(cv::Rect(50, 20, 20, 20)) = 0;
  ExpectLessSure(fits, scene.Judge(), {70, 30});
}

TEST(Confidence, IsLowerWhereBothImagesAreDark) {
  JudgedScene scene;
  scene.sigma_prior = kMaxSigmaCounts;  // far from sure, where a small doubt more can be seen
  scene.seeds.clear();
  const auto bright = scene.Judge();
  scene.left = scene.left / 32;  // matches as well
  scene.right = scene.right / 32;
  ExpectLessSure(bright, scene.Judge(), {70, 30});
}

TEST(Confidence, IsLowerBesideStepsOfMoreThanOnePixel) {
  JudgedScene scene;
  scene.right = uint8_t{128};  // nothing there that fits
  scene.sigma_prior = kMaxSigmaCounts;
  const auto judge = [&](int step_counts) {
    scene.map.counts() = ToCounts(4);
    scene.map.counts().colRange(60, 80) = static_cast<int16_t>(ToCounts(4) + step_counts);
    return scene.Judge();
  };
  const auto flat = judge(0);
  const auto slope = judge(DisparityImage::kCountsPerPixel);
  const auto edge = judge(DisparityImage::kCountsPerPixel + 1);
  EXPECT_EQ(slope.confidence(30, 52), flat.confidence(30, 52));
  EXPECT_LT(edge.confidence(30, 52), flat.confidence(30, 52));
  EXPECT_LT(slope.confidence(30, 60), flat.confidence(30, 60));  // the step itself
}

TEST(Confidence, IsLowerWhereGrowthLeftGaps) {
  JudgedScene scene;
  scene.right = uint8_t{128};
  scene.sigma_prior = kMaxSigmaCounts;  // far from sure, where a small doubt more can be seen
  scene.seeds.clear();
  const auto grown = scene.Judge();
  scene.grown.counts()(cv::Rect(60, 20, 15, 15)) = DisparityImage::kInvalid;
  const auto filled = scene.Judge();
  ExpectLessSure(grown, filled, {66, 26});
  EXPECT_EQ(filled.confidence(50, 66), grown.confidence(50, 66));
}

TEST(Confidence, IsLowerWhereNeighboursHaveTheSameGreyLevel) {
  JudgedScene scene;
  scene.right = uint8_t{128};
  scene.sigma_prior = kMaxSigmaCounts;
  scene.seeds.clear();
  const auto textured = scene.Judge();
  for (const int v : {26, 34}) scene.left.row(v) = uint8_t{90};  // beyond the other windows
  const auto blank = scene.Judge();
  ExpectLessSure(textured, blank, {70, 30});
  EXPECT_EQ(blank.confidence(48, 70), textured.confidence(48, 70));
}

TEST(Confidence, IsLowerWhereTheMapIsRoughAround) {
  JudgedScene scene;
  scene.right = uint8_t{128};
  scene.sigma_prior = kMaxSigmaCounts;
  scene.seeds.clear();
  const auto smooth = scene.Judge();
  cv::Mat1s far = scene.map.counts().colRange(42, 62);  // beyond the other windows
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < far.cols; ++u) {
      if ((u / 4 + v / 4) % 2 == 0) far(v, u) = ToCounts(10) + 30;  // no step above 1 px
    }
  }
  ExpectLessSure(smooth, scene.Judge(), {70, 30});
}

TEST(Confidence, CountsBlankCellsAndAveragesBends) {
  const JudgedScene scene;
  ConfidenceEstimator estimator;
  estimator.Compute(
      {scene.left, scene.right, scene.seeds, scene.sigma_prior, scene.grown, scene.map});
  const ConfidenceFeatures& features = estimator.features();
  const cv::Point cell(20, 15);
  int blank = 0;
  for (int y = cell.y - 2; y <= cell.y + 2; ++y) {
    for (int x = cell.x - 2; x <= cell.x + 2; ++x) {
      blank += scene.left(2 * y, 2 * x + 1) == scene.left(2 * y, 2 * x - 1) ? 1 : 0;
    }
  }
  EXPECT_EQ(features.blank(cell), 10 * blank);
  const cv::Point block(9, 7);
  double bends = 0;
  for (int y = block.y - 6; y <= block.y + 6; ++y) {
    for (int x = block.x - 6; x <= block.x + 6; ++x) bends += features.bend(2 * y, 2 * x);
  }
  EXPECT_EQ(features.rough(block), std::lround(bends / 169));
  EXPECT_GT(features.rough(block), 0);
}

TEST(Confidence, IsLowerInHolesBetweenTheSeeds) {
  JudgedScene scene;
  scene.right = uint8_t{128};  // nothing there that fits
  const auto without = scene.Judge();
  scene.seeds.push_back({.u = -7, .v = 1e9, .u_right = 0});  // not in the image
  EXPECT_EQ(cv::countNonZero(scene.Judge().confidence != without.confidence), 0);
  std::erase_if(scene.seeds,
                [](const Seed& seed) { return seed.u > 46 && seed.v > 10 && seed.v < 50; });
  ExpectLessSure(without, scene.Judge(), {70, 30});
  scene.seeds.clear();
  ExpectLessSure(without, scene.Judge(), {20, 30});
}

TEST(Confidence, IsLowerWhereThePriorIsLessSure) {
  JudgedScene scene;
  scene.right = uint8_t{128};  // what fits is sure whatever the prior is
  scene.sigma_prior = uint8_t{4};
  const auto surest = scene.Judge();
  auto before = surest;
  for (const int counts : {16, 64, 255}) {
    scene.sigma_prior = static_cast<uint8_t>(counts);
    auto after = scene.Judge();
    EXPECT_LE(after.confidence(30, 70), before.confidence(30, 70));
    EXPECT_GE(after.sigma(30, 70), before.sigma(30, 70));
    before = {after.confidence.clone(), after.sigma.clone()};
  }
  ExpectLessSure(surest, before, {70, 30});
  EXPECT_GT(before.sigma(30, 70), surest.sigma(30, 70));
  scene.sigma_prior = cv::Mat1b();  // not known: as 255
  const auto unknown = scene.Judge();
  EXPECT_EQ(cv::countNonZero(unknown.confidence != before.confidence), 0);
  EXPECT_EQ(cv::countNonZero(unknown.sigma != before.sigma), 0);
}

TEST(Confidence, IsNothingWithoutADisparity) {
  JudgedScene scene;
  scene.map.counts()(cv::Rect(11, 11, 5, 5)) = DisparityImage::kInvalid;
  const auto judged = scene.Judge();
  const cv::Mat none = scene.map.counts() == DisparityImage::kInvalid;
  EXPECT_EQ(cv::countNonZero((judged.confidence == 0) & none), cv::countNonZero(none));
  EXPECT_GT(judged.confidence(30, 70), 0);
  EXPECT_EQ(cv::countNonZero((judged.sigma == kMaxSigmaCounts) & none), cv::countNonZero(none));
  EXPECT_LT(judged.sigma(30, 70), kMaxSigmaCounts);
}

// Surfaces with edges and gaps, some of their disparities out of the image or below zero.
DisparityImage Patches(cv::Size size, cv::RNG& random) {
  DisparityImage map(size);
  map.counts() = static_cast<int16_t>(random.uniform(-100, 600));
  for (int i = 0; i < 12; ++i) {
    const cv::Rect patch(random.uniform(0, size.width), random.uniform(0, size.height),
                         random.uniform(1, 60), random.uniform(1, 40));
    map.counts()(patch & cv::Rect({}, size)) = static_cast<int16_t>(random.uniform(-32768, 32767));
  }
  for (int i = 0; i < size.area() / 20; ++i) {
    map.counts()(random.uniform(0, size.height), random.uniform(0, size.width)) =
        random.uniform(0, 3) == 0 ? DisparityImage::kInvalid
                                  : static_cast<int16_t>(random.uniform(-200, 2000));
  }
  return map;
}

TEST(Confidence, GivesTheSameBytesWithEveryInstructionSetAndNumberOfThreads) {
  cv::RNG random(5);
  for (const cv::Size size :
       {cv::Size(5, 5), {1, 1}, {2, 3}, {37, 9}, {131, 70}, {64, 203}, {250, 32}, {200, 129}}) {
    const cv::Mat1b left = Noise(size, 1, 256);
    const cv::Mat1b right = Noise(size, 2, 256);
    const DisparityImage filled = Patches(size, random);
    const cv::Mat1b sigma_prior = Noise(size, 3, 256);
    const DisparityImage grown = Patches(size, random);
    for (const int count : {0, 1, 40}) {
      const std::vector<Seed> seeds = RandomSeeds(size, count, 9, 3);
      const JudgedFrame frame{left, right, seeds, sigma_prior, grown, filled};
      cv::setNumThreads(1);
      const auto expected = ConfidenceEstimator().Compute(frame);
      ForEachInstructionSet([&](const std::string& name) {
        for (const int threads : {1, 2, 8}) {
          cv::setNumThreads(threads);
          ConfidenceEstimator estimator;
          for (const char* run : {"first", "second"}) {
            const auto judged = estimator.Compute(frame);
            EXPECT_EQ(cv::countNonZero(judged.confidence != expected.confidence), 0)
                << name << ", threads " << threads << ", " << size << ", " << run;
            EXPECT_EQ(cv::countNonZero(judged.sigma != expected.sigma), 0)
                << name << ", threads " << threads << ", " << size << ", " << run;
          }
        }
      });
      cv::setNumThreads(-1);
    }
  }
}

// Distances of the mask 3, 4 by definition: over all marks.
TEST(SpreadNearness, IsTheChamferDistanceToTheNextMark) {
  for (const cv::Size size : {cv::Size(1, 1), {1, 40}, {40, 1}, {200, 9}, {70, 120}}) {
    cv::RNG random(7);
    std::vector<cv::Point> marks;
    cv::Mat1b near(size, uint8_t{0});
    for (int i = 0; i < 3; ++i) {
      marks.emplace_back(random.uniform(0, size.width), random.uniform(0, size.height));
      near(marks.back()) = 255;
    }
    std::vector<uint8_t> memory;
    SpreadNearness(near, memory);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        int least = 255;
        for (const cv::Point mark : marks) {
          const int along = std::abs(mark.x - x);
          const int down = std::abs(mark.y - y);
          least = std::min(least, 3 * std::max(along, down) + std::min(along, down));
        }
        ASSERT_EQ(near(y, x), 255 - least) << size << " " << x << " " << y;
      }
    }
  }
}

}  // namespace
}  // namespace sprout::grow
