#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sprout::temporal {

/// Between a confidence and the variance of a disparity, (T1), both ways.
class ConfidenceScale {
 public:
  ConfidenceScale();

  /// px², of each confidence.
  const std::array<float, 256>& variances() const { return variances_; }

  /// (T9): what is left of the surer one of two disparities that disagree, px²: both may be wrong,
  /// not both right.
  /// @param a_px2, b_px2  > 0, of each by itself.
  float VarianceOfSurer(float a_px2, float b_px2) const {
    const int stays = ConfidenceOf(std::min(a_px2, b_px2));
    const int other = ConfidenceOf(std::max(a_px2, b_px2));
    const int left = 256 * stays * (256 - other) / (256 * 256 - stays * other);
    return variances_[static_cast<size_t>(left)];
  }

  /// The largest confidence whose variance is not below this one; 0 when there is none.
  /// @param variance_px2  > 0, finite.
  uint8_t ConfidenceOf(float variance_px2) const {
    return confidences_[std::bit_cast<uint32_t>(variance_px2) >> kDroppedBits];
  }

 private:
  // Lowest bits of a float that are dropped: sign, exponent and 7 bits of fraction are left, steps
  // of less than 1 %.
  static constexpr int kDroppedBits = 16;

  std::array<float, 256> variances_;
  std::vector<uint8_t> confidences_;  // by the first bits of a variance
};

}  // namespace sprout::temporal
