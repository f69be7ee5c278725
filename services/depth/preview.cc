#include "services/depth/preview.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <opencv2/imgproc.hpp>

#include "common/picture/picture.h"

namespace sprout::depth {
namespace {

cv::Size Shrunk(cv::Size size, int factor) {
  return {std::max(1, size.width / factor), std::max(1, size.height / factor)};
}

// Rows and columns that do not fill a block are left out, so that blocks have whole pixels.
cv::Mat ShrinkImage(const cv::Mat& image, int factor) {
  const cv::Size size = Shrunk(image.size(), factor);
  const cv::Size used(std::min(image.cols, factor * size.width),
                      std::min(image.rows, factor * size.height));
  cv::Mat small;
  cv::resize(image(cv::Rect({0, 0}, used)), small, size, 0, 0, cv::INTER_AREA);
  return small;
}

// Takes the middle of each block: a mean would be a disparity between two surfaces.
DisparityImage ShrinkMap(const DisparityImage& map, int factor) {
  DisparityImage small(Shrunk(map.size(), factor));
  for (int v = 0; v < small.height(); ++v) {
    for (int u = 0; u < small.width(); ++u) {
      small.counts()(v, u) = map.counts()(std::min(map.height() - 1, factor * v + factor / 2),
                                          std::min(map.width() - 1, factor * u + factor / 2));
    }
  }
  return small;
}

cv::Mat3b Beside(const cv::Mat3b& a, const cv::Mat3b& b) {
  cv::Mat3b both(std::max(a.rows, b.rows), a.cols + b.cols, cv::Vec3b(255, 255, 255));
  a.copyTo(both(cv::Rect({0, 0}, a.size())));
  b.copyTo(both(cv::Rect({a.cols, 0}, b.size())));
  return both;
}

}  // namespace

cv::Mat3b PreviewOf(const cv::Mat& left, const DisparityImage& disparity,
                    const RectifiedPair& pair) {
  assert(!left.empty() && left.size() == disparity.size() && disparity.size() == pair.size());
  const int side = std::max(left.cols, left.rows);
  const int factor = (side + kMaxPreviewSide - 1) / kMaxPreviewSide;
  const std::array maps = {ShrinkMap(disparity, factor)};
  const ValueRange range_px = DisparityRange(maps, {});
  return Beside(CameraPicture(ShrinkImage(left, factor), "left image"),
                DisparityPicture(maps[0], range_px, "depth", &pair));
}

}  // namespace sprout::depth
