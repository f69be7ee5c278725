#include "services/refine/range/range_costs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "tests/common/testing/instruction_sets.h"

namespace sprout::refine {
namespace {

const cv::Size kCostImage(120, 60);

cv::Mat1b Noise(uint64_t seed) {
  cv::Mat1b image(kCostImage);
  cv::RNG(seed).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

constexpr double kNoise = 0.5;  // grey levels²

// Eq. (R4) from its definition, in floating point.
double CostByDefinition(const cv::Mat1b& left, const cv::Mat1b& right, const SlantedPatch& patch,
                        double offset_px) {
  constexpr int kRadius = RangeRules::kWindowRadius;
  cv::Mat1d a;
  cv::Mat1d b;
  for (int y = -kRadius; y <= kRadius; ++y) {
    for (int x = -kRadius; x <= kRadius; ++x) {
      const int u = static_cast<int>(patch.at.x) + x;
      const int v = static_cast<int>(patch.at.y) + y;
      const double column =
          u - (patch.disparity_px + patch.slope.x * x + patch.slope.y * y + offset_px);
      const int before = static_cast<int>(std::floor(column));
      const double part = column - before;
      a.push_back(static_cast<double>(left(v, u)));
      b.push_back(right(v, before) * (1 - part) + right(v, before + 1) * part);
    }
  }
  cv::Mat1d a0;
  cv::Mat1d b0;
  cv::subtract(a, cv::mean(a), a0);
  cv::subtract(b, cv::mean(b), b0);
  const double n = static_cast<double>(a.total());
  const double likeness = 2 * a0.dot(b0) / n / (a0.dot(a0) / n + b0.dot(b0) / n + 2 * kNoise);
  return 1 - std::clamp(likeness, double{RangeRules::kMinLikeness}, 1.0);
}

TEST(RangeCosts, AreThoseOfTheirDefinitionWithEveryInstructionSet) {
  const cv::Mat1b left = Noise(1);
  cv::Mat1b right = Noise(2);
  left.colRange(20, 120).copyTo(right.colRange(0, 100));
  for (const double disparity_px : {18.0, 20.25, 23.5}) {
    const SlantedPatch patch{{70, 30}, disparity_px, {0.125, -0.0625}};
    OffsetCosts of_first_set{};
    ForEachInstructionSet([&](const std::string& set) {
      const std::optional<OffsetMoments> moments = MomentsOf(left, right, patch);
      ASSERT_TRUE(moments);
      const OffsetCosts costs = CostsOf(*moments, kNoise);
      for (int k = 0; k < RangeRules::kLabels; ++k) {
        // The right image is read between two pixels in steps of an eighth.
        EXPECT_NEAR(costs[static_cast<size_t>(k)],
                    CostByDefinition(left, right, patch, RangeRules::OffsetPx(k)), 0.08)
            << set << ", " << k;
      }
      if (of_first_set == OffsetCosts{}) of_first_set = costs;
      EXPECT_EQ(costs, of_first_set) << set;
    });
  }
}

TEST(RangeCosts, AreLeastWhereTheImagesAgree) {
  const cv::Mat1b left = Noise(1);
  cv::Mat1b right = Noise(2);
  left.colRange(20, 120).copyTo(right.colRange(0, 100));
  const auto moments = MomentsOf(left, right, {{70, 30}, 17, {0, 0}});  // 3 px too small
  ASSERT_TRUE(moments);
  const OffsetCosts costs = CostsOf(*moments, kNoise);
  const auto best = std::min_element(costs.begin(), costs.end()) - costs.begin();
  EXPECT_EQ(RangeRules::OffsetPx(static_cast<int>(best)), 3);
  EXPECT_LT(costs[static_cast<size_t>(best)], 0.01);
}

TEST(RangeCosts, AreNotKnownWhereAWindowLeavesAnImage) {
  const cv::Mat1b image = Noise(1);
  EXPECT_FALSE(MomentsOf(image, image, {{2, 30}, 0, {0, 0}}));
  EXPECT_FALSE(MomentsOf(image, image, {{60, 58}, 20, {0, 0}}));
  EXPECT_FALSE(MomentsOf(image, image, {{30, 30}, 40, {0, 0}}));
  EXPECT_FALSE(MomentsOf(image, image, {{60, 30}, 20, {0.5, 0}}));
  EXPECT_TRUE(MomentsOf(image, image, {{60, 30}, 20, {0.4, 0}}));
}

}  // namespace
}  // namespace sprout::refine
