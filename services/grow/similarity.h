#ifndef SPROUT_SERVICES_GROW_SIMILARITY_H_
#define SPROUT_SERVICES_GROW_SIMILARITY_H_

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"

// The paper's similarities, as costs: growth compares costs and takes the smallest, and never
// evaluates exp(). Costs are integers, so that sums and comparisons are the same on every machine.
namespace sprout {

/// Side of the correlation window, px (n = 5 in the paper).
inline constexpr int kWindow = 5;
inline constexpr int kWindowRadius = kWindow / 2;

/// Cost that stands for an exponent (or for a similarity difference, with MNCC) of 1.
inline constexpr int32_t kCostUnit = 1 << 20;

/// Cost of what can never be accepted.
inline constexpr int32_t kNoMatch = INT32_MAX;

/// Costs of the disparities d − 1, d, d + 1 at one left pixel, in this order.
using CostTriple = std::array<int32_t, 3>;

/// A cost from an exponent ≥ 0, rounded to nearest; large ones saturate below kNoMatch.
int32_t CostFromExponent(double exponent);

/// Σ wL·wR over 5×5 windows, the part of all similarities that depends on both images.
class CrossSums {
 public:
  /// @param left, right  grey images of one size.
  CrossSums(const cv::Mat1b& left, const cv::Mat1b& right);

  /// Sums of the left window at (u, v) with the right ones at the disparities d − 1, d, d + 1.
  /// @pre the left window lies in the image, the right window of d leaves it by at most one column
  ///      to the left. Outside the right image all is zero.
  CostTriple At(int u, int v, int d) const {
    const uint8_t* left = left_.ptr(v - kWindowRadius, u - kWindowRadius);
    const uint8_t* right =  // leftmost column of the window of d + 1
        right_padded_.ptr(v - kWindowRadius, u - (d + 1) - kWindowRadius + kPadding);
    CostTriple sums{};
    for (int y = 0; y < kWindow; ++y, left += left_.step, right += right_padded_.step) {
      for (int x = 0; x < kWindow; ++x) {
        sums[0] += left[x] * right[x + 2];
        sums[1] += left[x] * right[x + 1];
        sums[2] += left[x] * right[x];
      }
    }
    return sums;
  }

 private:
  static constexpr int kPadding = 2;  // columns on either side

  cv::Mat1b left_;
  cv::Mat1b right_padded_;
};

/// Eq. (1), Moravec's normalised cross-correlation:
///   MNCC = 2·cov(wL, wR) / (var(wL) + var(wR) + ε), ε the machine epsilon.
/// Its cost is 1 − MNCC.
class MnccCost {
 public:
  /// O(pixels).
  MnccCost(const cv::Mat1b& left, const cv::Mat1b& right);

  /// Cost up to which a similarity ≥ threshold is accepted.
  static int32_t Limit(double threshold);

  /// @pre as CrossSums::At(). Windows that leave the image are the caller's to refuse.
  CostTriple At(int u, int v, int d) const;

 private:
  CrossSums cross_;
  cv::Mat1i left_sum_, right_sum_;            // Σ w
  cv::Mat1i left_variance_, right_variance_;  // n²·Σ w² − (Σ w)², with n² = 25 pixels
};

/// Eq. (4), photo-consistency from the normalised sum of squared differences:
///   EXPSSD = exp(−Σ (wL − wR)² / (σ_s² · Σ (wL² + wR²))).
/// Its cost is the negated exponent. Two black windows are alike: cost 0.
class ExpssdCost {
 public:
  /// O(pixels).
  ExpssdCost(const cv::Mat1b& left, const cv::Mat1b& right, double sigma_s_squared);

  static int32_t Limit(double threshold);

  /// @pre as MnccCost::At().
  CostTriple At(int u, int v, int d) const;

 private:
  CrossSums cross_;
  cv::Mat1i left_energy_, right_energy_;  // Σ w²
  double sigma_s_squared_;
};

/// Eq. (6), photo-consistency times the prior of eq. (5):
///   EPC = EXPSSD · exp(−(d − D_p)² / (2·σ_p²)).
/// Its cost is the negated exponent. Where the prior has no value nothing matches.
class EpcCost {
 public:
  /// @param prior       D_p, of the size of the images.
  /// @param sigma_p_px  σ_p, px.
  /// O(pixels).
  EpcCost(const cv::Mat1b& left, const cv::Mat1b& right, const DisparityImage& prior,
          double sigma_s_squared, double sigma_p_px);

  static int32_t Limit(double threshold);

  /// @pre as MnccCost::At().
  CostTriple At(int u, int v, int d) const;

 private:
  ExpssdCost expssd_;
  DisparityImage prior_;
  double sigma_p_px_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_SIMILARITY_H_
