// What the prior allocates once it has seen a frame: nothing.
#include <gtest/gtest.h>

#include <cstdint>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "services/prior/prior_estimator.h"
#include "tests/common/testing/allocation_guard.h"

namespace sprout {
namespace {

// Colour noise, and noisy seeds on two surfaces.
struct Input {
  Input(cv::Size size, uint32_t seed) : left(size), right(size) {
    std::mt19937 random(seed);
    for (cv::Vec3b& value : left) {
      value = cv::Vec3b(static_cast<uint8_t>(random()), static_cast<uint8_t>(random()),
                        static_cast<uint8_t>(random()));
    }
    for (uint8_t& value : right) value = static_cast<uint8_t>(random());
    for (int i = 0; i < kSeeds; ++i) {
      const auto u = static_cast<float>(random() % static_cast<uint32_t>(size.width));
      const auto v = static_cast<float>(random() % static_cast<uint32_t>(size.height));
      const float disparity = u < 100 ? 5 : 20 + static_cast<float>(random() % 100) / 100;
      seeds.push_back({u, v, u - disparity});
    }
  }

  static constexpr int kSeeds = 300;

  cv::Mat3b left;
  cv::Mat1b right;
  std::vector<Seed> seeds;
};

// In steady state, of two frames.
int64_t AllocationsOf(PriorConfig::Method method) {
  cv::setNumThreads(1);  // handing work to other threads is OpenCV's business
  PriorConfig config;
  config.set_method(method);
  PriorEstimator estimator(config);
  const auto run = [&](const Input& input) {
    EXPECT_TRUE(estimator.Compute(input.left, input.right, input.seeds, input.left.size()));
  };
  const Input first({200, 150}, 1);
  const Input second({200, 150}, 2);
  for (int i = 0; i < 2; ++i) {
    run(first);
    run(second);
  }
  const AllocationGuard guard;
  run(first);
  run(second);
  return guard.count();
}

TEST(Allocation, PriorAllocatesNothing) {
  EXPECT_EQ(AllocationsOf(PriorConfig::DELAUNAY), 0);
  EXPECT_EQ(AllocationsOf(PriorConfig::EDGES), 0);
}

}  // namespace
}  // namespace sprout
