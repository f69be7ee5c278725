#include "services/prior/census.h"

#include <algorithm>
#include <cstdint>

#include "common/core/parallel.h"

namespace sprout {
namespace {

// Adds a bit for the pixel `across` columns to the right in another row, or the same.
void AddBit(const uint8_t* row, const uint8_t* other, int across, int columns, uint8_t* codes) {
  const int begin = across < 0 ? 1 : 0;
  const int end = across > 0 ? columns - 1 : columns;
  if (begin > 0) codes[0] = static_cast<uint8_t>(codes[0] << 1);
  for (int u = begin; u < end; ++u) {
    codes[u] = static_cast<uint8_t>(codes[u] << 1 | static_cast<int>(other[u + across] < row[u]));
  }
  if (end < columns) codes[end] = static_cast<uint8_t>(codes[end] << 1);
}

void TransformRow(const cv::Mat1b& image, int v, uint8_t* codes) {
  std::fill_n(codes, image.cols, uint8_t{0});
  for (int down = -1; down <= 1; ++down) {
    if (v + down < 0 || v + down >= image.rows) {
      for (int u = 0; u < image.cols; ++u) codes[u] = static_cast<uint8_t>(codes[u] << 3);
      continue;
    }
    for (int across = -1; across <= 1; ++across) {
      if (across == 0 && down == 0) continue;
      AddBit(image[v], image[v + down], across, image.cols, codes);
    }
  }
}

}  // namespace

void CensusTransform(const cv::Mat1b& image, cv::Mat1b& codes) {
  codes.create(image.size());
  ForRangesParallel(image.rows, 4 * cv::getNumThreads(), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) TransformRow(image, v, codes[v]);
  });
}

}  // namespace sprout
