#include "services/temporal/image_pyramid.h"

#include <algorithm>

#include "common/core/image.h"

namespace sprout::temporal {
namespace {

constexpr int kMinSide = 32;  // px: two windows of the tracker

cv::Mat1b Half(const cv::Mat1b& from) {
  return Halved(from(cv::Rect(0, 0, from.cols / 2 * 2, from.rows / 2 * 2)));
}

bool CanBeHalved(const cv::Mat1b& level) {
  return std::min(level.rows, level.cols) >= 2 * kMinSide;
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
