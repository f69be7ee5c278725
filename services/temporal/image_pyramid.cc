#include "services/temporal/image_pyramid.h"

#include <algorithm>

#include "common/core/parallel.h"

namespace sprout::temporal {
namespace {

constexpr int kSmallestSide = 32;  // px: two windows of the tracker

cv::Mat1b Half(const cv::Mat1b& from) {
  cv::Mat1b to(from.rows / 2, from.cols / 2);
  ForRangesParallel(to.rows, to.rows / kRowsPerPart + 1, [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      const uint8_t* const above = from[2 * v];
      const uint8_t* const below = from[2 * v + 1];
      uint8_t* const means = to[v];
      for (int u = 0; u < to.cols; ++u) {
        const int sum = above[2 * u] + above[2 * u + 1] + below[2 * u] + below[2 * u + 1];
        means[u] = static_cast<uint8_t>((sum + 2) >> 2);
      }
    }
  });
  return to;
}

bool CanBeHalved(const cv::Mat1b& level) {
  return std::min(level.rows, level.cols) >= 2 * kSmallestSide;
}

}  // namespace

ImagePyramid BuildPyramid(const cv::Mat1b& image) {
  ImagePyramid pyramid;
  if (image.empty()) return pyramid;
  cv::Mat1b level = image;
  while (static_cast<int64_t>(level.total()) > kMaxTrackedPixels && CanBeHalved(level)) {
    level = Half(level);
    pyramid.scale *= 2;
  }
  pyramid.levels.push_back(level);
  while (CanBeHalved(level)) pyramid.levels.push_back(level = Half(level));
  return pyramid;
}

}  // namespace sprout::temporal
