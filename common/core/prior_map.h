#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>

#include "common/core/disparity_image.h"

namespace sprout {

// Standard deviations are stored and sent as counts of 1/16 px in a byte: 1/16 px is finer than any
// prior's accuracy, and 16 px is as good as unknown.
inline constexpr int kSigmaCountsPerPx = 16;
/// 15.94 px or more; always so where there is no disparity. The smallest count is 1.
inline constexpr uint8_t kMaxSigmaCounts = 255;

/// A standard deviation in px to counts: rounded to nearest, at least 1, at most kMaxSigmaCounts;
/// so is NaN.
inline uint8_t SigmaToCounts(double sigma_px) {
  constexpr double kMaxPx = static_cast<double>(kMaxSigmaCounts) / kSigmaCountsPerPx;
  if (!(sigma_px < kMaxPx)) return kMaxSigmaCounts;
  return static_cast<uint8_t>(std::lround(std::max(1.0, sigma_px * kSigmaCountsPerPx)));
}

/// The inverse, px; exact. For kMaxSigmaCounts the smallest standard deviation that it stands for.
inline float SigmaToPx(uint8_t counts) { return static_cast<float>(counts) / kSigmaCountsPerPx; }

/// Standard deviations in px; infinite for kMaxSigmaCounts, which may be any larger one. O(pixels).
inline cv::Mat1f SigmaToPx(const cv::Mat1b& sigma) {
  cv::Mat1f px;
  sigma.convertTo(px, CV_32F, 1.0 / kSigmaCountsPerPx);
  px.setTo(std::numeric_limits<float>::infinity(), sigma == kMaxSigmaCounts);
  return px;
}

/// A prior disparity map D_p of the left rectified image, with a standard deviation at every pixel.
///
/// Copies share their pixels, as cv::Mat does.
struct PriorMap {
  DisparityImage disparity;
  /// Standard deviation of the disparity, counts of 1/16 px (SigmaToPx()); of the map's size,
  /// kMaxSigmaCounts where there is no disparity.
  cv::Mat1b sigma;

  /// A map without any pixel.
  PriorMap() = default;

  /// A map without any disparity.
  explicit PriorMap(cv::Size size) : disparity(size), sigma(size, kMaxSigmaCounts) {}

  PriorMap(DisparityImage map, cv::Mat1b counts)
      : disparity(std::move(map)), sigma(std::move(counts)) {}

  cv::Size size() const { return disparity.size(); }
  bool empty() const { return disparity.empty(); }
};

}  // namespace sprout
