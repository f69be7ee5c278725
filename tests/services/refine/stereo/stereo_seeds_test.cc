#include "services/refine/stereo/stereo_seeds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/common/testing/allocation_guard.h"

namespace sprout::refine {
namespace {

const cv::Size kSize(280, 200);
constexpr int kSpacing = 8;

// Fine and coarse texture, the same every time.
cv::Mat1b Texture(cv::Size size) {
  cv::Mat1b fine(size), coarse(size);
  cv::RNG random(7);
  random.fill(fine, cv::RNG::UNIFORM, 0, 256);
  random.fill(coarse, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(fine, fine, {}, 1);
  cv::GaussianBlur(coarse, coarse, {}, 4);
  cv::normalize(fine, fine, 0, 160, cv::NORM_MINMAX);
  cv::normalize(coarse, coarse, 0, 90, cv::NORM_MINMAX);
  fine += coarse;
  return fine;
}

// A pair that shows the surface d(u, v) of the right image, painted with a texture.
struct Pair {
  cv::Mat1b left;
  cv::Mat1b right;

  explicit Pair(cv::Mat1b texture, const std::function<double(int, int)>& disparity_of_right)
      : left(std::move(texture)), right(left.size()) {
    for (int v = 0; v < right.rows; ++v) {
      for (int u = 0; u < right.cols; ++u) {
        const double x = std::min(u + disparity_of_right(u, v), left.cols - 1.0);
        const int whole = std::min(static_cast<int>(x), left.cols - 2);
        const double part = x - whole;
        right(v, u) =
            cv::saturate_cast<uint8_t>((1 - part) * left(v, whole) + part * left(v, whole + 1));
      }
    }
  }
};

RefineConfig Config() {
  RefineConfig config;
  config.set_stereo_spacing_px(kSpacing);
  return config;
}

std::vector<Seed> Find(const Pair& pair, const RefineConfig& config = Config(),
                       const std::vector<Seed>& known = {},
                       const std::vector<cv::Point2f>& covered = {}, double spacing_px = 0) {
  StereoSeedFinder finder(config);
  const auto found = finder.Find(pair.left, pair.right, known, covered, spacing_px);
  return {found.begin(), found.end()};
}

TEST(StereoSeeds, FindsTheDisparitiesOfASlantedSurface) {
  const Pair pair(Texture(kSize), [](int, int v) { return 12 + 0.04 * v; });
  const std::vector<Seed> seeds = Find(pair);
  // What the right camera sees, too: the columns right of the disparity; and not the border.
  const double cells = (kSize.width - 30.0) * (kSize.height - 16.0) / (kSpacing * kSpacing);
  EXPECT_GT(static_cast<double>(seeds.size()), 0.8 * cells);
  for (const Seed& seed : seeds) {
    EXPECT_NEAR(seed.disparity(), 12 + 0.04 * seed.v, 0.4) << seed.u << " " << seed.v;
    EXPECT_EQ(seed.origin, SeedOrigin::kStereo);
    EXPECT_GT(seed.sigma_px, 0);
    EXPECT_LT(seed.sigma_px, 1);
  }
}

TEST(StereoSeeds, LooksOnlyWhereNoPointIsNear) {
  const Pair pair(Texture(kSize), [](int, int) { return 12; });
  std::vector<cv::Point2f> covered;
  for (int v = 0; v < kSize.height; v += kSpacing) {
    for (int u = 0; u < 140; u += kSpacing) {
      covered.emplace_back(static_cast<float>(u), static_cast<float>(v));
    }
  }
  const std::vector<Seed> seeds = Find(pair, Config(), {}, covered);
  EXPECT_GT(seeds.size(), 100U);
  for (const Seed& seed : seeds) EXPECT_GT(seed.u, 140);
}

// Points of a sensor on the surface that the pair shows, so many px apart; exact to 0.05 px.
std::vector<Seed> PointsOn(const std::function<double(double, double)>& disparity,
                           int across = 3 * kSpacing, int down = 3 * kSpacing) {
  std::vector<Seed> points;
  for (int v = 4; v < kSize.height; v += down) {
    for (int u = 44; u < kSize.width; u += across) {
      points.push_back({.u = static_cast<float>(u),
                        .v = static_cast<float>(v),
                        .u_right = static_cast<float>(u - disparity(u, v)),
                        .sigma_px = 0.05F});
    }
  }
  return points;
}

std::vector<cv::Point2f> PositionsOf(const std::vector<Seed>& points) {
  std::vector<cv::Point2f> positions;
  for (const Seed& point : points) positions.emplace_back(point.u, point.v);
  return positions;
}

// Seeds in the midst of these points, where they enclose a cell.
std::vector<Seed> FoundBetween(const Pair& pair, const std::vector<Seed>& points,
                               double spacing_px = 0) {
  std::vector<Seed> seeds = Find(pair, Config(), points, PositionsOf(points), spacing_px);
  std::erase_if(seeds, [](const Seed& seed) {
    return seed.u < 60 || seed.u > 240 || seed.v < 20 || seed.v > 170;
  });
  return seeds;
}

double SlantPx(double, double v) { return 12 + 0.04 * v; }

TEST(StereoSeeds, LeavesWhatPointsExplainToThem) {
  const Pair pair(Texture(kSize), [](int u, int v) { return SlantPx(u, v); });
  // At most 6 px beside a point: 0.16 px, while matches are hardly surer than 0.3.
  EXPECT_TRUE(FoundBetween(pair, PointsOn(SlantPx, 9, 9), 100).empty());
}

TEST(StereoSeeds, FillsStripsBetweenTheBeamsOfAScan) {
  const Pair pair(Texture(kSize), [](int u, int v) { return SlantPx(u, v); });
  const int strip_px = 8 * kSpacing;
  auto beams = PointsOn(SlantPx, 2, strip_px);
  for (Seed& point : beams) point.sigma_px = 0.3F;  // so that cells beside a beam are asked
  // The rows of cells beside a beam are its own where points are fine.
  const auto count = [&](double spacing_px, int least_cells) {
    const std::vector<Seed> seeds = FoundBetween(pair, beams, spacing_px);
    return std::count_if(seeds.begin(), seeds.end(), [&](const Seed& seed) {
      const int cells = (static_cast<int>(seed.v) / kSpacing) % 8;
      return std::min(cells, 8 - cells) >= least_cells;
    });
  };
  EXPECT_EQ(count(strip_px, 0), count(strip_px, 1));
  EXPECT_GT(count(strip_px, 2), 150);
  EXPECT_GT(count(strip_px, 1), count(strip_px, 2) + 20);
  EXPECT_EQ(count(1.4 * kSpacing, 1), count(1.4 * kSpacing, 2));
}

TEST(StereoSeeds, FillsTheGapsBetweenPointsWhosePlanesDisagree) {
  const auto rows = [](double v) { return static_cast<int>(v) / 20 % 2 == 0 ? 24.0 : 16.0; };
  const Pair pair(Texture(kSize), [&](int, int v) { return rows(v); });
  const std::vector<Seed> seeds =
      FoundBetween(pair, PointsOn([&](double, double v) { return rows(v); }));
  EXPECT_GT(seeds.size(), 40U);
  for (const Seed& seed : seeds) {
    EXPECT_NEAR(seed.disparity(), rows(double{seed.v}), 0.5) << seed.u << " " << seed.v;
  }
}

TEST(StereoSeeds, RefusesWhatHasNoTexture) {
  EXPECT_TRUE(Find(Pair(cv::Mat1b(kSize, uint8_t{120}), [](int, int) { return 12; })).empty());
}

TEST(StereoSeeds, RefusesWhatIsClipped) {
  cv::Mat1b texture = Texture(kSize);
  const cv::Rect white(100, 60, 80, 60);
  texture(white) = 255;
  const Pair pair(texture, [](int, int) { return 12; });
  const std::vector<Seed> seeds = Find(pair);
  EXPECT_GT(seeds.size(), 400U);
  const cv::Rect inside(white.x + 6, white.y + 6, white.width - 12, white.height - 12);
  for (const Seed& seed : seeds) {
    EXPECT_FALSE(inside.contains(cv::Point2f(seed.u, seed.v))) << seed.u << " " << seed.v;
  }
}

TEST(StereoSeeds, StaysAwayFromDepthEdges) {
  const auto disparity = [](double u, double v) {
    return u > 100 && u < 180 && v > 60 && v < 140 ? 30.0 : 10.0;  // of the right image
  };
  const Pair pair(Texture(kSize), disparity);
  const std::vector<Seed> seeds = Find(pair);
  EXPECT_GT(seeds.size(), 400U);
  const auto wrong = std::count_if(seeds.begin(), seeds.end(), [&](const Seed& seed) {
    return std::abs(seed.disparity() - disparity(double{seed.u_right}, double{seed.v})) > 0.5;
  });
  EXPECT_LE(wrong, std::ssize(seeds) / 100);
}

TEST(StereoSeeds, FindsNothingNearerThanAllowed) {
  const Pair pair(Texture(kSize), [](int, int) { return 40; });
  RefineConfig config = Config();
  EXPECT_GT(Find(pair, config).size(), 300U);
  config.set_stereo_max_disparity_px(20);
  for (const Seed& seed : Find(pair, config)) EXPECT_LE(seed.disparity(), 20);
}

TEST(StereoSeeds, LeansOnTheRangeSensorWhereTextureRepeats) {
  cv::Mat1b texture(kSize);  // repeats every 16 px
  const cv::Mat1b piece = Texture({16, kSize.height});
  for (int u = 0; u < texture.cols; ++u) piece.col(u % 16).copyTo(texture.col(u));
  const Pair pair(texture, [](int, int) { return 36; });
  std::vector<Seed> known;
  std::vector<cv::Point2f> covered;
  for (int v = 4; v < kSize.height; v += 4) {
    for (int u = 50; u < 140; u += 4) {
      known.push_back({.u = static_cast<float>(u),
                       .v = static_cast<float>(v),
                       .u_right = static_cast<float>(u - 36)});
      covered.emplace_back(known.back().u, known.back().v);
    }
  }
  const auto share_right = [](const std::vector<Seed>& seeds) {
    const auto count = std::count_if(seeds.begin(), seeds.end(), [](const Seed& seed) {
      return std::abs(seed.disparity() - 36) < 1;
    });
    return static_cast<double>(count) / static_cast<double>(seeds.size());
  };
  EXPECT_LT(share_right(Find(pair)), 0.5);
  EXPECT_GT(share_right(Find(pair, Config(), known, covered)), 0.7);
}

TEST(StereoSeeds, HalvesLargeImages) {
  const Pair pair(Texture(kSize), [](int, int) { return 24; });
  RefineConfig config = Config();
  config.set_stereo_most_pixels(kSize.area() / 4);
  const std::vector<Seed> seeds = Find(pair, config);
  EXPECT_GT(seeds.size(), 300U);
  for (const Seed& seed : seeds) EXPECT_NEAR(seed.disparity(), 24, 0.6);
}

// With one instruction set only, chosen anew at the next call; 0 = all that this CPU has.
void UseInstructionSet(int64_t set) {
  hwy::SetSupportedTargetsForTest(set);
  hwy::GetChosenTarget().DeInit();
}

TEST(StereoSeeds, CountsThePlacesWithoutAnAnswer) {
  StereoSeedFinder finder(Config());
  const Pair flat(cv::Mat1b(kSize, uint8_t{128}), [](int, int) { return 12; });
  const size_t cells = kSize.area() / (kSpacing * kSpacing);
  finder.Find(flat.left, flat.right, {}, {}, 0);
  EXPECT_EQ(finder.unanswered(), cells);
  const Pair pair(Texture(kSize), [](int, int) { return 12; });
  const size_t found = finder.Find(pair.left, pair.right, {}, {}, 0).size();
  EXPECT_EQ(finder.unanswered(), cells - found);
  // Left of the middle there are points.
  std::vector<cv::Point2f> points;
  for (int v = kSpacing / 2; v < kSize.height; v += 2 * kSpacing) {
    for (int u = kSpacing / 2; u < kSize.width / 2; u += 2 * kSpacing) points.emplace_back(u, v);
  }
  finder.Find(flat.left, flat.right, {}, points, 2 * kSpacing);
  EXPECT_LT(finder.unanswered(), cells / 2);
  EXPECT_GT(finder.unanswered(), cells / 3);
}

// A rig whose far points, in the upper tenth, have a disparity of −4 px, or of +4 px. Images of
// this size are halved to see that.
TEST(StereoSeeds, TellWhetherDisparitiesAreNegative) {
  constexpr int kColumns = 12;
  const cv::Size size(640, 420);
  const auto share = [&](int far_px) {
    const Pair wide(Texture(size + cv::Size(kColumns, 0)),
                    [&](int, int v) { return kColumns + (v < size.height / 10 ? far_px : 20); });
    return StereoSeedFinder(Config()).ShareBelowZero(wide.left.colRange(kColumns, wide.left.cols),
                                                     wide.right.colRange(0, size.width), kColumns);
  };
  EXPECT_NEAR(share(-4), 0.1, 0.03);
  EXPECT_LT(share(4), 0.002);
}

TEST(StereoSeeds, DependOnNeitherTheNumberOfThreadsNorTheInstructionSet) {
  const Pair pair(Texture({701, 403}), [](int u, int v) { return 20 + 0.02 * v + 0.01 * u; });
  std::vector<cv::Point2f> covered;  // so that parts of some rows are searched, and no others
  for (int v = 100; v < 220; v += 5) {
    for (int u = v; u < 500; u += 5) {
      covered.emplace_back(static_cast<float>(u), static_cast<float>(v));
    }
  }
  const std::vector<Seed> some = {{.u = 300, .v = 90, .u_right = 277}};
  const int before = cv::getNumThreads();
  cv::setNumThreads(1);
  constexpr double kCoarsePx = 40;  // between points: with four paths
  const std::vector<Seed> expected = Find(pair, Config(), some, covered);
  const std::vector<Seed> expected_of_coarse = Find(pair, Config(), some, covered, kCoarsePx);
  EXPECT_GT(expected.size(), 1000U);
  EXPECT_GT(expected_of_coarse.size(), 1000U);
  EXPECT_NE(expected_of_coarse, expected);
  cv::setNumThreads(3);
  EXPECT_EQ(Find(pair, Config(), some, covered), expected);
  EXPECT_EQ(Find(pair, Config(), some, covered, kCoarsePx), expected_of_coarse);
  cv::setNumThreads(before);
  std::vector<int64_t> sets = {HWY_SCALAR};
  for (int64_t all = hwy::SupportedTargets(); all != 0; all &= all - 1) sets.push_back(all & -all);
  for (const int64_t set : sets) {
    UseInstructionSet(set);
    EXPECT_EQ(Find(pair, Config(), some, covered), expected) << hwy::TargetName(set);
    EXPECT_EQ(Find(pair, Config(), some, covered, kCoarsePx), expected_of_coarse)
        << hwy::TargetName(set);
  }
  UseInstructionSet(0);
}

TEST(StereoSeeds, TakeImagesOfAnySize) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(5, 5), cv::Size(3, 400), cv::Size(400, 3),
                              cv::Size(33, 17), cv::Size(17, 900)}) {
    RefineConfig config = Config();
    config.set_stereo_max_disparity_px(1023);
    const Pair pair(Texture(size + cv::Size(1, 0)), [](int, int) { return 0; });
    for (const Seed& seed : Find(pair, config)) EXPECT_LE(seed.disparity(), size.width);
  }
}

// Few pixels, but thousands of disparities: all of them for every pixel are gigabytes.
TEST(StereoSeeds, OfWideAndLowImagesTakeLittleMemory) {
  for (const int rows : {1, 2, 5, 8}) {
    const Pair pair(Texture({16384, rows}), [](int, int) { return 12; });
    const AllocationGuard guard;
    const std::vector<Seed> seeds = Find(pair, RefineConfig());
    // The largest piece is the paths of a row of one: four directions a cost, and their padding.
    EXPECT_LT(AllocationGuard::largest(), 5 * StereoRules::kCoarsestCosts) << rows << " rows";
    EXPECT_EQ(seeds.empty(), rows < 5) << rows << " rows: whole windows";
  }
}

TEST(StereoSeeds, AreAtMostOneAPixel) {
  const Pair pair(Texture({200, 120}), [](int, int) { return 4; });
  RefineConfig config = Config();
  config.set_stereo_spacing_px(1);
  const size_t count = Find(pair, config).size();
  config.set_stereo_spacing_px(1e-9);
  EXPECT_EQ(Find(pair, config).size(), count);
}

TEST(StereoSeeds, RefuseParametersOutOfRange) {
  RefineConfig config;
  config.set_stereo_most_pixels(10);
  EXPECT_THAT([&] { StereoSeedFinder finder(config); },
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("refine.stereo_most_pixels")));
}

}  // namespace
}  // namespace sprout::refine
