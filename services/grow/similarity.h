#ifndef SPROUT_SERVICES_GROW_SIMILARITY_H_
#define SPROUT_SERVICES_GROW_SIMILARITY_H_

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

// The paper's similarities, as costs: growth compares costs and takes the smallest, and never
// evaluates exp(). Costs are integers, so that comparisons are the same on every machine. Growth
// computes them in window_costs-inl.h; here is what that shares with Harris seeds.
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

/// Costs from here on are as good as this one: beyond every limit.
inline constexpr float kLargestCost = 1 << 27;

/// Cost of a disparity whose window does not fit.
inline constexpr int32_t kExcludedCost = (1 << 29) - 1;

/// Exponent of eq. (5) as a cost, not yet whole. @param scale  cost of one squared count.
inline float PriorCost(int counts_from_prior, float scale) {
  const auto distance = static_cast<float>(counts_from_prior);
  return distance * distance * scale;
}

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

}  // namespace sprout

#endif  // SPROUT_SERVICES_GROW_SIMILARITY_H_
