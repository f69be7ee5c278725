#pragma once

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>

namespace sprout {

/// A row of the census transform (Zabih and Woodfill, ECCV 1994): for each pixel a bit for each of
/// the eight around it, set if that one is darker; 0 on the image's border. Always inline, so that
/// each caller gets vectors of its own instruction set.
/// @param census  gets a byte a pixel of the row.
[[gnu::always_inline]] inline void CensusOfRow(const cv::Mat1b& image, int v,
                                               uint8_t* __restrict census) {
  std::fill_n(census, image.cols, uint8_t{0});
  if (v == 0 || v == image.rows - 1) return;
  const uint8_t* __restrict above = image[v - 1];
  const uint8_t* __restrict row = image[v];
  const uint8_t* __restrict below = image[v + 1];
  for (int u = 1; u < image.cols - 1; ++u) {
    const uint8_t around[8] = {above[u - 1], above[u],     above[u + 1], row[u - 1],
                               row[u + 1],   below[u - 1], below[u],     below[u + 1]};
    int bits = 0;
    for (int i = 0; i < 8; ++i) bits |= around[i] < row[u] ? 128 >> i : 0;
    census[u] = static_cast<uint8_t>(bits);
  }
}

}  // namespace sprout
