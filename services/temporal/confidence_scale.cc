#include "services/temporal/confidence_scale.h"

namespace sprout::temporal {
namespace {

constexpr double kMaxVariance = 1e5;  // px², of a disparity that is surely wrong

// P(|N(0, 1)| > z) for z ≤ 4, by the series of the error function: those of libraries differ in the
// last bit.
double Beyond(double z) {
  constexpr double kRootOfTwoByPi = 0.79788456080286535588;
  double power = z;  // z²ⁿ⁺¹ / (2ⁿ n!), with the sign of n
  double sum = 0;
  for (int n = 0; n < 60; ++n) {
    sum += power / (2 * n + 1);
    power *= -z * z / (2 * (n + 1));
  }
  return 1 - kRootOfTwoByPi * sum;
}

// The variance of a normal error that is above 1 px with this probability.
double VarianceOf(double probability) {
  double nearest = 0;
  double farthest = 4;  // standard deviations that 1 px is
  for (int i = 0; i < 50; ++i) {
    const double middle = (nearest + farthest) / 2;
    (Beyond(middle) > probability ? nearest : farthest) = middle;
  }
  return std::min(1 / (farthest * farthest), kMaxVariance);
}

}  // namespace

ConfidenceScale::ConfidenceScale() : confidences_(std::size_t{1} << (32 - kDroppedBits - 1)) {
  for (std::size_t confidence = 0; confidence < variances_.size(); ++confidence) {
    // 255 is rounded, too: between 0 and half a count.
    const double counts = std::max(255.0 - static_cast<double>(confidence), 0.25);
    variances_[confidence] = static_cast<float>(VarianceOf(counts / 255));
  }
  std::size_t confidence = 255;
  for (uint32_t bits = 0; bits < confidences_.size(); ++bits) {
    const auto variance = std::bit_cast<float>(bits << kDroppedBits);
    while (confidence > 0 && !(variances_[confidence] >= variance)) --confidence;
    confidences_[bits] = static_cast<uint8_t>(confidence);
  }
}

}  // namespace sprout::temporal
