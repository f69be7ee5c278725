#include "services/evaluate/rivals/padded_pair.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace sprout {
namespace {

constexpr int kStep = 16;  // OpenCV searches multiples of this many disparities

cv::Mat PadLeft(const cv::Mat& image, int columns) {
  cv::Mat padded;
  cv::copyMakeBorder(image, padded, 0, 0, columns, 0, cv::BORDER_REPLICATE);
  return padded;
}

}  // namespace

PaddedPair::PaddedPair(const cv::Mat& left, const cv::Mat& right, int max_disparity_px)
    : disparities_((max_disparity_px / kStep + 1) * kStep),
      left_(PadLeft(left, disparities_)),
      right_(PadLeft(right, disparities_)) {}

cv::Mat1f PaddedPair::Crop(const cv::Mat1s& map) const {
  constexpr float kCountsPerPixel = cv::StereoMatcher::DISP_SCALE;
  const cv::Mat1s counts = map.colRange(disparities_, map.cols);
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

}  // namespace sprout
