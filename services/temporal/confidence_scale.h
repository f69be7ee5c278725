#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace sprout::temporal {

/// Between a confidence and the variance of a disparity, (T1), both ways.
class ConfidenceScale {
 public:
  ConfidenceScale();

  /// px², of each confidence.
  const std::array<float, 256>& variances() const { return variances_; }

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
