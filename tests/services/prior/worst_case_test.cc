// Seeds that crowd, or make one seed the neighbour of all others, must not take the prior longer
// than its stated worst case.
#include <gtest/gtest.h>

#include "services/prior/prior_estimator.h"
#include "services/prior/seed_neighbours.h"
#include "tests/common/testing/worst_seeds.h"

namespace sprout {
namespace {

class WorstPrior : public testing::TestWithParam<PriorConfig::Method> {};

TEST_P(WorstPrior, IsNotQuadratic) {
  const cv::Size size(2048, 1024);
  cv::Mat3b left(size);
  cv::RNG(1).fill(left, cv::RNG::UNIFORM, 0, 255);
  cv::Mat3b right(size);
  cv::RNG(2).fill(right, cv::RNG::UNIFORM, 0, 255);
  PriorConfig config;
  config.set_method(GetParam());
  for (const auto& [name, seeds] : MakeWorstSeeds(size)) {
    PriorEstimator prior(config);
    EXPECT_LT(CpuSeconds([&] { (void)prior.Compute(left, right, seeds, size).has_value(); }),
              kWorstSeconds)
        << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, WorstPrior,
                         testing::Values(PriorConfig::DELAUNAY, PriorConfig::EDGES));

TEST(WorstCase, ASeedMayBeTheNeighbourOfAllOthers) {
  std::vector<SeedTriangle> fan;
  for (int i = 1; i + 1 < kWorstCount; ++i) fan.push_back({0, i, i + 1});
  SeedNeighbours neighbours;
  const double seconds = CpuSeconds([&] { neighbours.Find(kWorstCount, fan); });
  EXPECT_LT(seconds, kWorstSeconds / 10);
  EXPECT_EQ(neighbours.Of(0).size(), kWorstCount - 1);
  EXPECT_EQ(neighbours.Of(1).size(), 2U);
  EXPECT_EQ(neighbours.Of(2).size(), 3U);
}

}  // namespace
}  // namespace sprout
