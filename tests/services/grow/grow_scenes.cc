#include "tests/services/grow/grow_scenes.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/common/config/with.h"
#include "tests/common/core/even_prior.h"

namespace sprout::grow {

cv::Mat1b Noise(cv::Size size, uint32_t seed, int levels) {
  std::mt19937 random(seed);
  cv::Mat1b image(size);
  for (uint8_t& value : image) {
    value = static_cast<uint8_t>(random() % static_cast<uint32_t>(levels) * 255 /
                                 static_cast<uint32_t>(levels));
  }
  return image;
}

cv::Mat1b ShiftedBy(const cv::Mat1b& left, int d) {
  cv::Mat1b right(left.size(), uint8_t{0});
  left.colRange(d, left.cols).copyTo(right.colRange(0, left.cols - d));
  return right;
}

PriorMap ConstantPrior(cv::Size size, double disparity) {
  return EvenPrior(DisparityImage(cv::Mat1s(size, ToCounts(disparity))), 1);
}

void ExpectSame(const DisparityImage& fast, const DisparityImage& slow) {
  ASSERT_EQ(fast.size(), slow.size());
  for (int v = 0; v < fast.height(); ++v) {
    for (int u = 0; u < fast.width(); ++u) {
      ASSERT_EQ(fast.counts()(v, u), slow.counts()(v, u)) << "at (" << u << ", " << v << ")";
    }
  }
}

std::vector<Seed> RandomSeeds(cv::Size size, int count, int max_disparity, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Seed> seeds;
  for (int i = 0; i < count; ++i) {
    const auto u = static_cast<float>(random() % static_cast<uint32_t>(size.width));
    const auto v = static_cast<float>(random() % static_cast<uint32_t>(size.height));
    const float d = static_cast<float>(random() % static_cast<uint32_t>(4 * max_disparity)) / 4;
    seeds.push_back({u, v, u - d});
  }
  return seeds;
}

GrowConfig EpcConfig() {
  return With<GrowConfig>(
      "similarity: EPC sigma_s_squared: 0.1 sigma_p_px: 2 sigma_p_noise: 0 sub_pixel: false");
}

}  // namespace sprout::grow
