// Growth and gap filling must not allocate once they have seen a frame.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "services/grow/confidence.h"
#include "services/grow/gap_filler.h"
#include "services/grow/grower.h"
#include "tests/common/core/even_prior.h"
#include "tests/common/testing/allocation_guard.h"

namespace sprout {
namespace {

struct Input {
  explicit Input(cv::Size size, uint32_t seed) : left(size), right(size) {
    std::mt19937 random(seed);
    for (uint8_t& value : left) value = static_cast<uint8_t>(random());
    right = 0;
    left.colRange(5, size.width).copyTo(right.colRange(0, size.width - 5));
    prior = EvenPrior(DisparityImage(cv::Mat1s(size, ToCounts(5))), 1);
    for (int i = 0; i < 200; ++i) {
      const auto u = static_cast<float>(random() % static_cast<uint32_t>(size.width));
      const auto v = static_cast<float>(random() % static_cast<uint32_t>(size.height));
      seeds.push_back({u, v, u - 5});
    }
  }

  cv::Mat1b left;
  cv::Mat1b right;
  std::vector<Seed> seeds;
  PriorMap prior;
};

TEST(Allocation, GrowthAndFillingAllocateNothingInSteadyState) {
  cv::setNumThreads(1);  // handing work to other threads is OpenCV's business
  const Input first({200, 150}, 1);
  const Input second({200, 150}, 2);
  for (const auto similarity : {GrowConfig::EPC, GrowConfig::EXPSSD, GrowConfig::MNCC}) {
    GrowConfig config;
    config.set_similarity(similarity);
    Grower grower(config);
    GapFiller filler;
    int64_t valid = 0;
    const auto run = [&](const Input& input) {
      const auto map = grower.Compute(input.left, input.right, input.seeds, input.prior);
      for (const auto fill : {GrowConfig::ONE_PASS, GrowConfig::UNTIL_STABLE, GrowConfig::PRIOR}) {
        const DisparityImage filled = filler.Fill(*map, fill, input.prior.disparity);
        valid += cv::countNonZero(filled.counts());
      }
    };
    run(first);
    run(second);
    const AllocationGuard guard;
    run(first);
    run(second);
    EXPECT_EQ(guard.count(), 0) << GrowConfig::Similarity_Name(similarity);
    EXPECT_GT(valid, 0);
  }
}

// What is left are OpenCV's morphology (2 filters), box filters (4) and distance transforms (2).
TEST(Allocation, ConfidenceAllocatesNothingBesidesOpenCvsFilters) {
  cv::setNumThreads(1);
  const Input first({200, 150}, 1);
  const Input second({200, 150}, 2);
  ConfidenceJudge judge;
  const auto run = [&](const Input& input) {
    const DisparityImage& map = input.prior.disparity;
    judge.Judge(input.left, input.right, input.seeds, map, map, 0.1);
  };
  run(first);
  run(second);
  const AllocationGuard guard;
  run(first);
  run(second);
  EXPECT_LE(guard.count() / 2, 60);  // 55 with OpenCV 4.6
}

}  // namespace
}  // namespace sprout
