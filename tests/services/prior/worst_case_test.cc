// Seeds that crowd, or make one seed the neighbour of all others, must not take the prior longer
// than its stated worst case.
#include <gtest/gtest.h>

#include "services/prior/prior_estimator.h"
#include "tests/common/testing/worst_seeds.h"

namespace sprout::prior {
namespace {

class WorstPrior : public testing::TestWithParam<PriorConfig::Method> {};

TEST_P(WorstPrior, IsNotQuadratic) {
  const cv::Size size(640, 480);
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

}  // namespace
}  // namespace sprout::prior
