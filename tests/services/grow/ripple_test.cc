// A flat wall must come out flat: how far the sub-pixel disparities of a slightly slanted textured
// wall lie off, and how much of that repeats from pixel to pixel of disparity.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "services/grow/grower.h"
#include "tests/common/core/even_prior.h"

namespace sprout::grow {
namespace {

constexpr int kFine = 16;  // samples a pixel
constexpr int kRows = 96;
constexpr int kColumns = 420;

// Random texture, kFine samples a pixel along the row; a pixel of a camera sees the mean of as
// many.
// @param blur_px  of the lens.
cv::Mat1f WallTexture(double blur_px) {
  cv::Mat1f texture(kRows, 2 * (kColumns + 40));
  cv::RNG(7).fill(texture, cv::RNG::NORMAL, 0, 1);
  cv::resize(texture, texture, {}, kFine / 2.0, 1, cv::INTER_LINEAR);
  cv::GaussianBlur(texture, texture, {}, blur_px * kFine, blur_px);
  cv::blur(texture, texture, {kFine, 1});
  cv::Scalar mean, deviation;
  cv::meanStdDev(texture, mean, deviation);
  const double contrast = 40 / deviation[0];
  texture.convertTo(texture, -1, contrast, 120 - contrast * mean[0]);
  return texture;
}

double DisparityAt(int u, int v) { return 10 + 0.01 * u + 0.02 * v; }

uint8_t GreyAt(const cv::Mat1f& texture, double u, int v) {
  const auto column = static_cast<int>(std::lround((u + 20) * kFine));
  return cv::saturate_cast<uint8_t>(texture(v, column));
}

struct Ripple {
  double rms_px = 0;       // of all errors
  double repeated_px = 0;  // r.m.s. of the mean error by the fraction of the true disparity
};

// @param sigma_px  of a prior that is right: small, and pixels are swept; large, and they grow.
Ripple RippleOfWall(double blur_px, double sigma_px) {
  const cv::Mat1f texture = WallTexture(blur_px);
  cv::Mat1b left(kRows, kColumns);
  cv::Mat1b right(kRows, kColumns);
  DisparityImage truth(left.size());
  std::vector<Seed> seeds;
  for (int v = 0; v < kRows; ++v) {
    for (int u = 0; u < kColumns; ++u) {
      const double d = DisparityAt(u, v);
      left(v, u) = GreyAt(texture, u - d, v);
      right(v, u) = GreyAt(texture, u, v);
      truth.counts()(v, u) = ToCounts(d);
      if (u % 10 == 5 && v % 10 == 5) {
        seeds.push_back({static_cast<float>(u), static_cast<float>(v), static_cast<float>(u - d)});
      }
    }
  }
  const DisparityImage map =
      Grower(GrowConfig()).Compute(left, right, seeds, EvenPrior(truth, sigma_px)).value();
  constexpr int kParts = 16;
  std::array<double, kParts> sums{};
  std::array<int, kParts> counts{};
  double squares = 0;
  int count = 0;
  for (int v = 4; v < kRows - 4; ++v) {
    for (int u = 40; u < kColumns - 4; ++u) {
      if (!map.IsValid(u, v)) continue;
      const double d = DisparityAt(u, v);
      const double error = double{map.Px(u, v)} - d;
      const auto part = static_cast<size_t>((d - std::floor(d)) * kParts);
      sums[part] += error;
      ++counts[part];
      squares += error * error;
      ++count;
    }
  }
  EXPECT_GT(count, 0.85 * (kRows - 8) * (kColumns - 44));  // one-to-one matching leaves gaps
  double repeated = 0;
  for (size_t i = 0; i < kParts; ++i) repeated += std::pow(sums[i] / counts[i], 2) / kParts;
  return {std::sqrt(squares / count), std::sqrt(repeated)};
}

// A parabola through three costs in place of (S2): 0.040 and 0.026 px; 0.074 and 0.059 px.
TEST(Ripple, IsSmallOnASweptWall) {
  const Ripple soft = RippleOfWall(0.5, 0.1);
  EXPECT_LT(soft.rms_px, 0.024);
  EXPECT_LT(soft.repeated_px, 0.012);
  const Ripple sharp = RippleOfWall(0.2, 0.1);
  EXPECT_LT(sharp.rms_px, 0.052);
  EXPECT_LT(sharp.repeated_px, 0.028);
}

// With little of the prior in the step. The parabola: 0.070 and 0.046 px.
TEST(Ripple, IsSmallOnAWallThatGrows) {
  const Ripple soft = RippleOfWall(0.5, 1.5);
  EXPECT_LT(soft.rms_px, 0.04);
  EXPECT_LT(soft.repeated_px, 0.02);
}

}  // namespace
}  // namespace sprout::grow
