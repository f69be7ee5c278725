#include "services/pipeline/files/doubt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "common/core/prior_map.h"

namespace sprout {
namespace {

using inputs::Question;

// How far columns may be off, px; infinite: anywhere.
double ColumnErrorPx(const inputs::Findings& findings) {
  if (AnyIsBad(findings, {Question::kScene, Question::kSides})) {
    return std::numeric_limits<double>::infinity();
  }
  double error_px = 0;
  for (const inputs::Finding& finding : findings) {
    if (inputs::AnyIsBad({finding}, {Question::kRows, Question::kTime})) {
      error_px = std::max(error_px, std::abs(finding.value));
    }
  }
  return error_px;
}

template <typename Function>
void ForEachCount(cv::Mat1b& counts, Function of) {
  std::array<uint8_t, 256> table{};
  for (size_t i = 0; i < table.size(); ++i) table[i] = of(static_cast<uint8_t>(i));
  for (uint8_t& count : counts) count = table[count];
}

void DropBelow(int least, const cv::Mat1b& confidence, DisparityImage& map) {
  if (least > 0 && !confidence.empty()) {
    map.counts().setTo(DisparityImage::kInvalid, confidence < least);
  }
}

}  // namespace

bool BoundConfidence(const inputs::Findings& findings, const SproutConfig& config,
                     DepthFrame& depth) {
  const double error_px = ColumnErrorPx(findings);
  if (error_px <= 1) return false;
  const auto bounded = [&](uint8_t confidence) {
    return static_cast<uint8_t>(confidence / error_px);
  };
  ForEachCount(depth.confidence, bounded);
  ForEachCount(depth.fused_confidence, bounded);
  ForEachCount(depth.sigma, [&](uint8_t counts) {
    const double sigma_px = std::hypot(SigmaToPx(counts), error_px / std::numbers::sqrt3);
    return counts == kMaxSigmaCounts ? counts : SigmaToCounts(sigma_px);
  });
  const bool of_fused = config.depth().input() == DepthConfig::FUSED;
  const int least = config.grow().min_confidence();
  DropBelow(least, depth.confidence, depth.disparity);
  DropBelow(std::max(config.depth().min_confidence(), of_fused ? 0 : least),
            of_fused ? depth.fused_confidence : depth.confidence, depth.kept);
  depth.depth_m.setTo(std::numeric_limits<float>::quiet_NaN(),
                      depth.kept.counts() == DisparityImage::kInvalid);
  return true;
}

}  // namespace sprout
