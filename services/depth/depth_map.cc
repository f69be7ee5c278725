#include "services/depth/depth_map.h"

#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "common/core/quantile.h"

namespace sprout::depth {
namespace {

// Counts of every disparity that a map can have: at 2 MP the division would be done 2 million times
// for 65536 results. Index: counts of disparity + 32768.
std::vector<uint16_t> DepthTable(const RectifiedPair& pair, double metres_per_count) {
  constexpr int kSize = 1 << 16;
  std::vector<uint16_t> table(kSize, 0);
  for (int i = 1; i < kSize; ++i) {  // 0: DisparityImage::kInvalid
    const double disparity_px =
        (i + double{DisparityImage::kInvalid}) / DisparityImage::kCountsPerPixel;
    const double counts = pair.DepthFromDisparity(disparity_px) / metres_per_count;
    if (!(counts > 0) || counts >= std::numeric_limits<uint16_t>::max() + 0.5) continue;
    table[static_cast<size_t>(i)] = static_cast<uint16_t>(std::lround(counts));
  }
  return table;
}

// Median of the depths in a block; 0 when less than half of its pixels have one.
uint16_t MedianOfBlock(const cv::Mat1w& counts, int u, int v, int scale) {
  std::array<uint16_t, 16> depths{};
  size_t found = 0;
  for (int y = v; y < v + scale; ++y) {
    for (int x = u; x < u + scale; ++x) {
      if (counts(y, x) > 0) depths[found++] = counts(y, x);
    }
  }
  if (2 * found < static_cast<size_t>(scale * scale)) return 0;
  return OrderStatistic(std::span(depths).first(found), (found - 1) / 2);
}

}  // namespace

DepthImage DepthOf(const DisparityImage& disparity, const RectifiedPair& pair,
                   double metres_per_count, int scale) {
  assert(disparity.size() == pair.size() && scale >= 1 && scale <= 4);
  const std::vector<uint16_t> table = DepthTable(pair, metres_per_count);
  cv::Mat1w counts(disparity.size());
  for (int v = 0; v < counts.rows; ++v) {
    const int16_t* const disparities = disparity.counts()[v];
    uint16_t* const depths = counts[v];
    for (int u = 0; u < counts.cols; ++u) {
      depths[u] = table[static_cast<size_t>(disparities[u] - int{DisparityImage::kInvalid})];
    }
  }
  // The centre of block 0 is at (scale − 1) / 2 of the whole image.
  const double shift = (scale - 1) / 2.0;
  DepthImage depth{.counts = counts,
                   .metres_per_count = metres_per_count,
                   .focal_px = pair.focal_px / scale,
                   .cx = (pair.cx - shift) / scale,
                   .cy = (pair.cy - shift) / scale};
  if (scale == 1) return depth;
  depth.counts = cv::Mat1w(counts.rows / scale, counts.cols / scale);
  for (int v = 0; v < depth.counts.rows; ++v) {
    for (int u = 0; u < depth.counts.cols; ++u) {
      depth.counts(v, u) = MedianOfBlock(counts, scale * u, scale * v, scale);
    }
  }
  return depth;
}

}  // namespace sprout::depth
