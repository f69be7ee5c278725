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

int32_t LimitOfExponent(double threshold) { return CostFromExponent(-std::log(threshold)); }

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
  for (int i = 0; i < 3; ++i) {
    const int u_right = std::clamp(u - (d - 1 + i), 0, right_sum_.cols - 1);
    // n⁴ times covariance and variances: integers, exact.
    const int covariance = kWindowPixels * costs[i] - left_sum_(v, u) * right_sum_(v, u_right);
    const int variances = left_variance_(v, u) + right_variance_(v, u_right);
    costs[i] = CostFromExponent(1 - 2.0 * covariance / (variances + kEpsilon));  // Eq. (1)
  }
  return costs;
}

ExpssdCost::ExpssdCost(const cv::Mat1b& left, const cv::Mat1b& right, double sigma_s_squared)
    : cross_(left, right),
      left_energy_(WindowSumsOfSquares(left)),
      right_energy_(WindowSumsOfSquares(right)),
      sigma_s_squared_(sigma_s_squared) {}

int32_t ExpssdCost::Limit(double threshold) { return LimitOfExponent(threshold); }

CostTriple ExpssdCost::At(int u, int v, int d) const {
  CostTriple costs = cross_.At(u, v, d);
  for (int i = 0; i < 3; ++i) {
    const int u_right = std::clamp(u - (d - 1 + i), 0, right_energy_.cols - 1);
    const int energy = left_energy_(v, u) + right_energy_(v, u_right);
    const int ssd = energy - 2 * costs[i];  // Σ (wL − wR)²
    costs[i] = energy == 0 ? 0 : CostFromExponent(ssd / (sigma_s_squared_ * energy));  // Eq. (4)
  }
  return costs;
}

EpcCost::EpcCost(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityImage& prior,
                 double sigma_s_squared, double sigma_p_px)
    : expssd_(left, right, sigma_s_squared), prior_(prior), sigma_p_px_(sigma_p_px) {}

int32_t EpcCost::Limit(double threshold) { return LimitOfExponent(threshold); }

CostTriple EpcCost::At(int u, int v, int d) const {
  const int16_t prior = prior_.counts()(v, u);
  if (prior == DisparityImage::kInvalid) return {kNoMatch, kNoMatch, kNoMatch};
  CostTriple costs = expssd_.At(u, v, d);
  const double counts_to_sigmas = 1 / (sigma_p_px_ * DisparityImage::kCountsPerPixel);
  for (int i = 0; i < 3; ++i) {
    const double deviation =  // from the prior, in σ_p
        ((d - 1 + i) * DisparityImage::kCountsPerPixel - prior) * counts_to_sigmas;
    costs[i] += CostFromExponent(deviation * deviation / 2);  // Eqs. (5) and (6)
  }
  return costs;
}

}  // namespace sprout
