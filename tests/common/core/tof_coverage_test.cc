#include "common/core/tof_coverage.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace sprout {
namespace {

Seed SeedAt(float u, float v) { return {.u = u, .v = v, .u_right = u}; }

// One seed every `step` px.
std::vector<Seed> Grid(cv::Size size, int step) {
  std::vector<Seed> seeds;
  for (int v = 0; v < size.height; v += step) {
    for (int u = 0; u < size.width; u += step) {
      seeds.push_back(SeedAt(static_cast<float>(u), static_cast<float>(v)));
    }
  }
  return seeds;
}

TEST(TofCoverage, IsTheShareOfCellsWithASeed) {
  const cv::Size size(640, 480);  // 40 × 30 cells of 16 px
  EXPECT_EQ(TofCoverage({}, size), 0);
  EXPECT_FLOAT_EQ(TofCoverage(std::vector{SeedAt(5, 5)}, size), 1.F / 1200);
  EXPECT_FLOAT_EQ(TofCoverage(std::vector{SeedAt(5, 5), SeedAt(9, 2)}, size), 1.F / 1200);
  EXPECT_FLOAT_EQ(TofCoverage(std::vector{SeedAt(15.4F, 5), SeedAt(15.6F, 5)}, size), 2.F / 1200);
  EXPECT_EQ(TofCoverage(Grid(size, 16), size), 1);
  EXPECT_FLOAT_EQ(TofCoverage(Grid({320, 480}, 16), size), 0.5F);
}

TEST(TofCoverage, HasCellsOfAtLeast8Px) {
  EXPECT_FLOAT_EQ(TofCoverage(std::vector{SeedAt(0, 0)}, {128, 96}), 1.F / (16 * 12));
  EXPECT_EQ(TofCoverage(std::vector{SeedAt(0, 0)}, {7, 3}), 1);
  EXPECT_EQ(TofCoverage(std::vector{SeedAt(0, 0)}, {1, 1}), 1);
}

TEST(TofCoverage, HasNoSmallCellsAtTheBorders) {
  EXPECT_FLOAT_EQ(TofCoverage(std::vector{SeedAt(640, 480)}, {641, 481}), 1.F / 1200);
  for (const cv::Size size : {cv::Size(641, 481), cv::Size(679, 495), cv::Size(1242, 375)}) {
    EXPECT_EQ(TofCoverage(Grid(size, size.width / 40), size), 1) << size.width;
  }
}

TEST(TofCoverage, CountsNeitherStereoSeedsNorThoseOutside) {
  const cv::Size size(640, 480);
  Seed stereo = SeedAt(5, 5);
  stereo.origin = SeedOrigin::kStereo;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(TofCoverage(std::vector{stereo, SeedAt(-0.6F, 5), SeedAt(5, -0.6F), SeedAt(639.5F, 5),
                                    SeedAt(5, 479.5F), SeedAt(kNan, 5), SeedAt(5, 1e30F)},
                        size),
            0);
  EXPECT_GT(TofCoverage(std::vector{SeedAt(639.4F, 479.4F)}, size), 0);
  EXPECT_GT(TofCoverage(std::vector{SeedAt(-0.5F, -0.5F)}, size), 0);
}

}  // namespace
}  // namespace sprout
