#pragma once

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

namespace sprout {

/// Sums over the grey values of two windows, for correlations.
struct WindowSums {
  int32_t left = 0, right = 0;
  int32_t left_squares = 0, right_squares = 0, products = 0;
};

/// The sums of the windows of (2 · kRadius + 1)² px around a left and a right pixel, which must lie
/// inside the images. Whole numbers, so exact. kRadius at most 90, since sums have 32 bits.
template <int kRadius>
WindowSums SumWindows(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point at_left,
                      cv::Point at_right) {
  static_assert(kRadius >= 0 && kRadius <= 90);
  WindowSums sums;
  for (int y = -kRadius; y <= kRadius; ++y) {
    const uint8_t* a = left.ptr(at_left.y + y) + at_left.x - kRadius;
    const uint8_t* b = right.ptr(at_right.y + y) + at_right.x - kRadius;
    for (int x = 0; x <= 2 * kRadius; ++x) {
      sums.left += a[x];
      sums.right += b[x];
      sums.left_squares += a[x] * a[x];
      sums.right_squares += b[x] * b[x];
      sums.products += a[x] * b[x];
    }
  }
  return sums;
}

/// Normalised cross-correlation of these windows, −1 to 1; −1 where one has no texture.
template <int kRadius>
double WindowCorrelation(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point at_left,
                         cv::Point at_right) {
  constexpr double kPixels = (2 * kRadius + 1) * (2 * kRadius + 1);
  const WindowSums sums = SumWindows<kRadius>(left, right, at_left, at_right);
  const double left_variance = sums.left_squares - double(sums.left) * sums.left / kPixels;
  const double right_variance = sums.right_squares - double(sums.right) * sums.right / kPixels;
  if (!(left_variance > 0 && right_variance > 0)) return -1;
  return (sums.products - double(sums.left) * sums.right / kPixels) /
         std::sqrt(left_variance * right_variance);
}

/// Variance of white noise in the window of (2 · kRadius + 1)² px around a pixel, by Immerkær's
/// operator (CVIU 1996), which surfaces and edges hardly pass: σ = √(π/2) / 6 · mean |I * N|.
/// @pre the window and one pixel around it lie inside the image.
template <int kRadius>
double NoiseVariance(const cv::Mat1b& image, cv::Point at) {
  int sum = 0;
  for (int y = at.y - kRadius; y <= at.y + kRadius; ++y) {
    const uint8_t* above = image[y - 1];
    const uint8_t* row = image[y];
    const uint8_t* below = image[y + 1];
    for (int x = at.x - kRadius; x <= at.x + kRadius; ++x) {
      sum += std::abs(above[x - 1] - 2 * above[x] + above[x + 1] - 2 * row[x - 1] + 4 * row[x] -
                      2 * row[x + 1] + below[x - 1] - 2 * below[x] + below[x + 1]);
    }
  }
  constexpr double kPixels = (2 * kRadius + 1) * (2 * kRadius + 1);
  const double sigma = std::sqrt(CV_PI / 2) / 6 * sum / kPixels;
  return sigma * sigma;
}

/// Whether a position lies more than the margin, px, inside the centres of an image's outermost
/// pixels. With a margin of r − ½ the window of radius r around the rounded position lies in the
/// image. False for NaN and positions far outside, so check before converting to a pixel.
inline bool IsInside(double u, double v, cv::Size size, double margin_u, double margin_v) {
  return u > margin_u && u < size.width - 1 - margin_u && v > margin_v &&
         v < size.height - 1 - margin_v;
}
inline bool IsInside(double u, double v, cv::Size size, double margin) {
  return IsInside(u, v, size, margin, margin);
}

}  // namespace sprout
