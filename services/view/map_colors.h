#pragma once

#include <algorithm>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/core/disparity_image.h"
#include "common/core/rig.h"
#include "common/picture/color_map.h"

namespace sprout::view {

/// The colours of the scale, 256 times "rrggbb", from the smallest disparity to the largest one.
std::string ScaleColors();

/// The colours of all 65536 counts of a disparity map, so that painting one is a table look-up.
class CountColors {
 public:
  /// Colours by disparity.
  static CountColors OfDisparity(const ValueRange& range_px);

  /// Colours by the depth of a disparity, see ColorOfDepth().
  static CountColors OfDepth(const RectifiedPair& pair, const ValueRange& range_m);

  /// O(pixels).
  cv::Mat3b Paint(const cv::Mat1s& counts) const;

 private:
  template <typename ColorOfPx>
  explicit CountColors(ColorOfPx color_of_px);

  std::vector<cv::Vec3b> table_;
};

/// Every N-th pixel of a map, so that it has at most `width` columns; values are not changed.
/// O(pixels of the result).
template <typename T>
cv::Mat_<T> Thin(const cv::Mat_<T>& map, int width) {
  if (map.cols <= width) return map;
  const double step = static_cast<double>(map.cols) / width;
  const int height = std::max(1, cvRound(map.rows / step));
  cv::Mat_<T> thin(height, width);
  std::vector<int> columns(static_cast<size_t>(width));
  for (int u = 0; u < width; ++u) {
    columns[static_cast<size_t>(u)] = std::min(map.cols - 1, static_cast<int>((u + 0.5) * step));
  }
  for (int v = 0; v < height; ++v) {
    const T* from = map[std::min(map.rows - 1, static_cast<int>((v + 0.5) * step))];
    T* to = thin[v];
    for (const int u : columns) *to++ = from[u];
  }
  return thin;
}

/// Keeps a colour scale stable: it changes only when the values of a frame leave it, or fill less
/// than half of it.
class StableRange {
 public:
  /// @param range  of this frame's values.
  /// @returns the range to use.
  ValueRange Follow(const ValueRange& range);

 private:
  std::optional<ValueRange> range_;
};

/// Ranges of a frame's disparities (px) and, with a calibration, of its depths (m), from some
/// 20,000 of its pixels. The nearest depth is above 0.
ValueRange DisparityRangeOf(const DisparityImage& map);
ValueRange DepthRangeOf(const DisparityImage& map, const RectifiedPair& pair);

}  // namespace sprout::view
