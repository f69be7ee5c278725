#include "services/tools/evaluate/rivals/padded_pair.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace sprout::evaluate {
namespace {

constexpr int kStep = 16;  // OpenCV searches multiples of this many disparities

}  // namespace

PaddedPair::PaddedPair(const cv::Mat& left, const cv::Mat& right, int max_disparity_px, int block,
                       Views views)
    : disparities_((max_disparity_px / kStep + 1) * kStep),
      margin_(block / 2),
      columns_left_(disparities_ + margin_),
      columns_right_(views == Views::kBoth ? columns_left_ : margin_),
      left_(Pad(left)),
      right_(Pad(right)) {}

cv::Mat PaddedPair::Pad(const cv::Mat& image) const {
  cv::Mat padded;
  cv::copyMakeBorder(image, padded, margin_, margin_, columns_left_, columns_right_,
                     cv::BORDER_REPLICATE);
  return padded;
}

cv::Mat1f PaddedPair::Crop(const cv::Mat1s& map) const {
  constexpr float kCountsPerPixel = cv::StereoMatcher::DISP_SCALE;
  const cv::Mat1s counts =
      map.rowRange(margin_, map.rows - margin_).colRange(columns_left_, map.cols - columns_right_);
  cv::Mat1f disparity_px(counts.size());
  std::transform(counts.begin(), counts.end(), disparity_px.begin(), [](int16_t count) {
    return count < 0 ? std::numeric_limits<float>::quiet_NaN() : count / kCountsPerPixel;
  });
  return disparity_px;
}

cv::Mat1f MatchPadded(cv::StereoMatcher& matcher, const PaddedPair& pair) {
  cv::Mat1s map;
  matcher.compute(pair.left(), pair.right(), map);
  return pair.Crop(map);
}

}  // namespace sprout::evaluate
