#include "services/temporal/confidence_scale.h"

#include <bit>

namespace sprout::temporal {
namespace {

// Measured on KITTI's frames, see NOTES.md.
constexpr double kSurestPx = 0.35;
// exp(1/90). By products, since exp() differs between machines.
constexpr double kStep = 1.0111730687663378;

}  // namespace

ConfidenceScale::ConfidenceScale() : confidences_(std::size_t{1} << (32 - kDroppedBits - 1)) {
  double sigma_px = kSurestPx;
  for (std::size_t confidence = 256; confidence-- > 0; sigma_px *= kStep) {
    variances_[confidence] = static_cast<float>(sigma_px * sigma_px);
  }
  std::size_t confidence = 255;
  for (uint32_t bits = 0; bits < confidences_.size(); ++bits) {
    const auto variance = std::bit_cast<float>(bits << kDroppedBits);
    while (confidence > 0 && !(variances_[confidence] >= variance)) --confidence;
    confidences_[bits] = static_cast<uint8_t>(confidence);
  }
}

}  // namespace sprout::temporal
