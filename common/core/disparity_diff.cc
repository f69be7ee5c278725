#include "common/core/disparity_diff.h"

#include <algorithm>
#include <cstdlib>

namespace sprout {

DisparityDiff Compare(const DisparityImage& a, const DisparityImage& b) {
  DisparityDiff diff;
  diff.pixels = static_cast<int64_t>(a.counts().total());
  int64_t sum = 0;
  int max = 0;
  for (int v = 0; v < a.height(); ++v) {
    const int16_t* const row_a = a.counts()[v];
    const int16_t* const row_b = b.counts()[v];
    for (int u = 0; u < a.width(); ++u) {
      if (row_a[u] == row_b[u]) continue;
      if (diff.differing++ == 0) diff.first = {u, v};
      if (row_a[u] == DisparityImage::kInvalid) {
        ++diff.newly_valid;
      } else if (row_b[u] == DisparityImage::kInvalid) {
        ++diff.newly_invalid;
      } else {
        const int distance = std::abs(row_b[u] - row_a[u]);
        ++diff.changed;
        diff.moved += distance > DisparityImage::kCountsPerPixel;
        sum += distance;
        max = std::max(max, distance);
      }
    }
  }
  diff.sum_px = static_cast<double>(sum) / DisparityImage::kCountsPerPixel;
  diff.max_px = static_cast<double>(max) / DisparityImage::kCountsPerPixel;
  return diff;
}

}  // namespace sprout
