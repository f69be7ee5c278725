#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>

namespace sprout {

/// Dense disparity map of the left rectified image: d = u − u' in fixed point, 32 counts a pixel,
/// in memory as in messages. Largest disparity: 1023 px.
///
/// Copies share their pixels, as cv::Mat does.
class DisparityImage {
 public:
  static constexpr int kCountsPerPixel = 32;
  static constexpr int16_t kInvalid = std::numeric_limits<int16_t>::min();
  /// Largest whole disparity around which all sub-pixel ones can be stored.
  static constexpr int kMaxWholePx = std::numeric_limits<int16_t>::max() / kCountsPerPixel;
  static constexpr double kMaxPx = std::numeric_limits<int16_t>::max() / double{kCountsPerPixel};

  DisparityImage() = default;

  /// A map without any disparity.
  explicit DisparityImage(cv::Size size) : counts_(size, kInvalid) {}

  /// Takes counts as they are (shared, not copied).
  explicit DisparityImage(cv::Mat1s counts) : counts_(std::move(counts)) {}

  int width() const { return counts_.cols; }
  int height() const { return counts_.rows; }
  cv::Size size() const { return counts_.size(); }
  bool empty() const { return counts_.empty(); }

  const cv::Mat1s& counts() const { return counts_; }
  cv::Mat1s& counts() { return counts_; }

  bool IsValid(int u, int v) const { return counts_(v, u) != kInvalid; }

  /// Disparity at a pixel, px; NaN where there is none.
  float Px(int u, int v) const {
    return IsValid(u, v) ? static_cast<float>(counts_(v, u)) / kCountsPerPixel
                         : std::numeric_limits<float>::quiet_NaN();
  }

  /// Whether a pixel has a disparity. Stops at the first one.
  bool AnyValid() const {
    return std::any_of(counts_.begin(), counts_.end(), [](int16_t c) { return c != kInvalid; });
  }

  /// Number of pixels with a disparity.
  int64_t CountValid() const { return counts_.empty() ? 0 : cv::countNonZero(counts_ != kInvalid); }

 private:
  cv::Mat1s counts_;
};

/// Disparity in px to counts, rounded to nearest; kInvalid when out of range or not finite.
inline int16_t ToCounts(double disparity_px) {
  if (!(std::abs(disparity_px) <= DisparityImage::kMaxPx)) return DisparityImage::kInvalid;
  return static_cast<int16_t>(std::lround(disparity_px * DisparityImage::kCountsPerPixel));
}

/// Disparities in px, NaN where there is none; exact. O(pixels).
inline cv::Mat1f ToPx(const DisparityImage& disparity) {
  cv::Mat1f px(disparity.size());
  for (int v = 0; v < px.rows; ++v) {
    for (int u = 0; u < px.cols; ++u) px(v, u) = disparity.Px(u, v);
  }
  return px;
}

/// The map of disparities in px, as ToCounts() rounds each. O(pixels).
inline DisparityImage FromPx(const cv::Mat1f& px) {
  DisparityImage disparity(px.size());
  for (int v = 0; v < px.rows; ++v) {
    for (int u = 0; u < px.cols; ++u) disparity.counts()(v, u) = ToCounts(px(v, u));
  }
  return disparity;
}

}  // namespace sprout
