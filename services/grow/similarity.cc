#include "services/grow/similarity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace sprout {
namespace {

constexpr int kWindowPixels = kWindow * kWindow;

cv::Mat1i WindowSums(const cv::Mat1b& image) {
  cv::Mat1i sums;
  cv::boxFilter(image, sums, CV_32S, {kWindow, kWindow}, {-1, -1}, /*normalize=*/false);
  return sums;
}

cv::Mat1i WindowSumsOfSquares(const cv::Mat1b& image) {
  cv::Mat1i sums;
  cv::sqrBoxFilter(image, sums, CV_32S, {kWindow, kWindow}, {-1, -1}, /*normalize=*/false);
  return sums;
}

cv::Mat1i ScaledVariances(const cv::Mat1b& image, const cv::Mat1i& sums) {
  return cv::Mat1i(kWindowPixels * WindowSumsOfSquares(image) - sums.mul(sums));
}

}  // namespace

int32_t CostFromExponent(double exponent) {
  constexpr double kLargest = 1000;  // exp(−1000) is no similarity worth telling from others
  return static_cast<int32_t>(std::min(exponent, kLargest) * kCostUnit + 0.5);
}

CrossSums::CrossSums(const cv::Mat1b& left, const cv::Mat1b& right) : left_(left) {
  cv::copyMakeBorder(right, right_padded_, 0, 0, kPadding, kPadding, cv::BORDER_CONSTANT);
}

MnccCost::MnccCost(const cv::Mat1b& left, const cv::Mat1b& right)
    : cross_(left, right),
      left_sum_(WindowSums(left)),
      right_sum_(WindowSums(right)),
      left_variance_(ScaledVariances(left, left_sum_)),
      right_variance_(ScaledVariances(right, right_sum_)) {}

int32_t MnccCost::Limit(double threshold) { return CostFromExponent(1 - threshold); }

CostTriple MnccCost::At(int u, int v, int d) const {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  CostTriple costs = cross_.At(u, v, d);
  for (size_t i = 0; i < costs.size(); ++i) {
    const int disparity = d - 1 + static_cast<int>(i);
    const int u_right = std::clamp(u - disparity, 0, right_sum_.cols - 1);
    // n⁴ times covariance and variances: integers, exact.
    const int covariance = kWindowPixels * costs[i] - left_sum_(v, u) * right_sum_(v, u_right);
    const int variances = left_variance_(v, u) + right_variance_(v, u_right);
    costs[i] = CostFromExponent(1 - 2.0 * covariance / (variances + kEpsilon));  // Eq. (1)
  }
  return costs;
}

}  // namespace sprout
