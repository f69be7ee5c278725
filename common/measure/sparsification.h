#pragma once

#include <array>
#include <opencv2/core.hpp>

namespace sprout {

/// Sparsification curve of a confidence: bad 1 (error > 1 px or no disparity, per cent) of the
/// pixels with the highest confidence. Errors are spread evenly over pixels of equal confidence.
/// NaN when no pixel is scored.
struct Sparsification {
  static constexpr int kSteps = 20;

  /// Element i: of the best (i + 1)·5 % of the pixels; the last one is bad 1 of all pixels.
  std::array<double, kSteps> bad1_percent{};
  double area_percent = 0;         ///< mean of the curve, in steps of 1 %
  double oracle_area_percent = 0;  ///< the same if the wrong pixels came last

  /// Bad 1 of the best `percent` % of the pixels, a multiple of 5.
  double BestPercent(int percent) const {
    return bad1_percent[static_cast<size_t>(percent * kSteps / 100 - 1)];
  }
};

/// @param disparity_px, truth, mask  as Score(), of one size.
/// @param confidence                 of that size; higher: trusted more.
/// O(pixels).
Sparsification Sparsify(const cv::Mat1f& disparity_px, const cv::Mat1f& truth,
                        const cv::Mat1b& mask, const cv::Mat1b& confidence);

}  // namespace sprout
