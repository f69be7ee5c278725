#include "services/pipeline/files/bound_confidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/core/prior_map.h"
#include "common/core/quantile.h"

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

// 1 where range points show the depth: no farther from one than it is from one to the next, and
// not as near to a match of the images.
cv::Mat1b ShownByRanges(const DepthFrame& depth) {
  std::vector<Seed> seeds;
  Join(depth.seeds.seeds, depth.left_seeds.seeds, seeds);
  cv::Mat1b shown(depth.disparity.size(), uint8_t{0});
  cv::Mat1b matched = shown.clone();
  std::vector<float> steps_px;
  const Seed* before = nullptr;
  for (const Seed& seed : seeds) {
    const bool is_point = seed.origin == SeedOrigin::kTof && seed.tof_u >= 0;
    const cv::Point at(cvRound(seed.u), cvRound(seed.v));
    if (cv::Rect({}, shown.size()).contains(at)) (is_point ? shown : matched)(at) = 1;
    if (!is_point) continue;
    if (before != nullptr && seed.tof_v == before->tof_v && seed.tof_u == before->tof_u + 1) {
      steps_px.push_back(std::abs(seed.u - before->u));
    }
    before = &seed;
  }
  if (steps_px.empty()) return cv::Mat1b(shown.size(), uint8_t{0});
  const int side = 2 * static_cast<int>(std::ceil(Median(steps_px))) + 1;
  const cv::Mat around = cv::Mat::ones(side, side, CV_8U);
  cv::dilate(shown, shown, around);
  cv::dilate(matched, matched, around);
  shown.setTo(0, matched);
  return shown;
}

// Changes counts but where ranges show them.
template <typename Function>
void ForEachCount(cv::Mat1b& counts, const cv::Mat1b& shown, Function of) {
  std::array<uint8_t, 256> table{};
  for (size_t i = 0; i < table.size(); ++i) table[i] = of(static_cast<uint8_t>(i));
  for (int v = 0; v < counts.rows; ++v) {
    for (int u = 0; u < counts.cols; ++u) {
      if (shown(v, u) == 0) counts(v, u) = table[counts(v, u)];
    }
  }
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
  const cv::Mat1b shown = depth.ranges_alone && std::isfinite(error_px)
                              ? ShownByRanges(depth)
                              : cv::Mat1b(depth.disparity.size(), uint8_t{0});
  ForEachCount(depth.confidence, shown, bounded);
  ForEachCount(depth.fused_confidence, shown, bounded);
  ForEachCount(depth.sigma, shown, [&](uint8_t counts) {
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
