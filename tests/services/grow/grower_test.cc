#include "services/grow/grower.h"

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>

#include "tests/common/config/with.h"
#include "tests/services/grow/grow_scenes.h"

namespace sprout::grow {
namespace {

TEST(Grower, GrowsAcrossManyBandsFromOneSeed) {
  const cv::Size size(40, 400);
  const cv::Mat1b left = Noise(size, 1, 256);
  const std::vector<Seed> seeds = {{.u = 20, .v = 390, .u_right = 15}};
  const auto map =
      Grower(EpcConfig()).Compute(left, ShiftedBy(left, 5), seeds, ConstantPrior(size, 5));
  EXPECT_EQ(map->CountValid(), 396 * 31);
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
  // A window across a step passes, a wrong one does not.
  const auto config = With("similarity: EXPSSD sigma_s_squared: 0.2", EpcConfig());
  const std::vector<Seed> seeds = {{.u = 15, .v = 6, .u_right = 7}};
  const auto map = Grower(config).Compute(left, right, seeds, PriorMap());
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
  const auto config = With("sigma_p_px: 1000 sub_pixel: true", EpcConfig());
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

TEST(Grower, SearchesAsFarAsThePriorIsUnsure) {
  const cv::Size size(60, 40);
  const cv::Mat1b left = Noise(size, 1, 256);
  const cv::Mat1b right = ShiftedBy(left, 5);
  auto config = With("sigma_p_px: 0.7 sigma_p_noise: 2 sigma_p_sure_px: 0.5", EpcConfig());
  const std::vector<Seed> seeds = {{30, 20, 25}, {20, 20, 15}, {45, 20, 40}};
  PriorMap prior = ConstantPrior(size, 7);  // 2 px off
  // Pixels that got a disparity, and those that got the right one.
  const auto grown = [&] {
    const DisparityImage map = Grower(config).Compute(left, right, seeds, prior).value();
    return std::pair{static_cast<int>(map.CountValid()),
                     cv::countNonZero(map.counts() == ToCounts(5))};
  };
  // Both windows must lie in the images, which rows 2 to 37 and columns 7 to 57 do.
  const std::pair nothing{0, 0}, everything{36 * 51, 36 * 51};
  // The images agree, so eq. (6) is at least 0.5 up to a distance of σ_p·√(2·ln 2), and
  // σ_p = max(0.7, 2·√(σ² − 0.5²)): 0.82 px, 1.87 px, 2.04 px and 3.33 px.
  for (const auto& [sigma_px, expected] :
       {std::pair{0.5, nothing}, std::pair{0.9375, nothing}, std::pair{1.0, everything},
        std::pair{1.5, everything}}) {
    prior.sigma = SigmaToCounts(sigma_px);
    EXPECT_EQ(grown(), expected) << sigma_px;
  }
  prior.sigma.colRange(0, 40) = SigmaToCounts(0.5);
  EXPECT_EQ(grown(), (std::pair{36 * 18, 36 * 18})) << "columns 40 to 57";
  config.set_sigma_p_noise(0);
  EXPECT_EQ(grown(), nothing);
}

TEST(Grower, RefusesAPriorWithoutStandardDeviations) {
  const cv::Size size(60, 40);
  const cv::Mat1b left = Noise(size, 1, 256);
  const PriorMap prior{DisparityImage(size), cv::Mat1b()};
  EXPECT_FALSE(Grower(EpcConfig()).Compute(left, left, {}, prior).has_value());
}

TEST(Grower, KeepsOneToOneMatching) {
  const cv::Size size(50, 30);
  const cv::Mat1b flat(size, uint8_t{128});  // every disparity fits everywhere
  const auto map = Grower(With("sigma_p_px: 1000", EpcConfig()))
                       .Compute(flat, flat, RandomSeeds(size, 40, 12, 3), ConstantPrior(size, 5));
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

TEST(Grower, GivesTheSameBytesWhenItsMemoryIsUsedAgain) {
  const cv::Size size(60, 40);
  const cv::Mat1b left = Noise(size, 6, 4);
  const cv::Mat1b right = ShiftedBy(left, 3);
  const std::vector<Seed> seeds = RandomSeeds(size, 30, 8, 6);
  Grower grower(EpcConfig());
  const auto first = grower.Compute(left, right, seeds, ConstantPrior(size, 3));
  ASSERT_GT(first->CountValid(), 1000);
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
  EXPECT_THAT(grower.Compute(tiny, tiny, {}, PriorMap(tiny.size())).error().text,
              testing::HasSubstr("smaller than the 5x5 window"));
  EXPECT_THAT(grower.Compute(image, image, {}, PriorMap(cv::Size(3, 3))).error().text,
              testing::HasSubstr("prior of 3x3"));
}

TEST(Grower, WorksOnImagesOfExactlyOneWindow) {
  const cv::Mat1b image = Noise({5, 5}, 8, 256);
  const std::vector<Seed> seeds = {{2, 2, 2}};
  EXPECT_TRUE(
      Grower(EpcConfig()).Compute(image, image, seeds, ConstantPrior({5, 5}, 0)).has_value());
}

TEST(Grower, RefusesAThresholdOutOfRange) {
  EXPECT_THROW(Grower{With<GrowConfig>("threshold: 1.5")}, ConfigError);
}

}  // namespace
}  // namespace sprout::grow
