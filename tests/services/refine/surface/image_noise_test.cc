#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "services/refine/surface/range_noise.h"

namespace sprout::refine {
namespace {

constexpr double kShiftPx = 8;

// Texture, and the same 8 px further left.
struct NoisePair {
  NoisePair() {
    cv::RNG random(5);
    random.fill(left, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(left, left, {}, 1);
    left.colRange(8, left.cols).copyTo(right.colRange(0, left.cols - 8));
  }
  cv::Mat1b left = cv::Mat1b(200, 300);
  cv::Mat1b right = cv::Mat1b(200, 300, uint8_t{0});
};

// Points 10 px apart.
std::vector<ProjectedPoint> NoisyPoints(double noise_px) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal(0, 1);
  std::vector<ProjectedPoint> points;
  for (int v = 10; v < 195; v += 10) {
    for (int u = 20; u < 280; u += 10) {
      ProjectedPoint point;
      point.seed.u = static_cast<float>(u);
      point.seed.v = static_cast<float>(v);
      point.seed.u_right = static_cast<float>(u - kShiftPx - noise_px * normal(random));
      points.push_back(point);
    }
  }
  return points;
}

TEST(ImageNoise, IsWhatTheImagesShow) {
  const NoisePair pair;
  EXPECT_LT(ImageNoisePx(pair.left, pair.right, NoisyPoints(0)), 0.1);
  // Of 1 px the 0.5 px of a match that errs are taken off, which these do not.
  EXPECT_NEAR(ImageNoisePx(pair.left, pair.right, NoisyPoints(1)), 0.8, 0.3);
}

TEST(ImageNoise, IsUnknownWithoutTextureOrPoints) {
  const cv::Mat1b grey(200, 300, uint8_t{90});
  EXPECT_TRUE(std::isinf(ImageNoisePx(grey, grey, NoisyPoints(1))));
  const NoisePair pair;
  EXPECT_TRUE(std::isinf(ImageNoisePx(pair.left, pair.right, {})));
  std::vector<ProjectedPoint> outside = NoisyPoints(0);
  for (ProjectedPoint& point : outside) point.seed.u -= 1e6F;
  EXPECT_TRUE(std::isinf(ImageNoisePx(pair.left, pair.right, outside)));
}

}  // namespace
}  // namespace sprout::refine
