#ifndef SPROUT_SERVICES_EVALUATE_RIVALS_PADDED_PAIR_H_
#define SPROUT_SERVICES_EVALUATE_RIVALS_PADDED_PAIR_H_

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

namespace sprout {

/// OpenCV's matchers give no disparity to the leftmost columns, as many as they search disparities,
/// although most of those pixels are seen by both cameras. So that no method is charged for that
/// band, both images are padded on the left by the search range, and the map is cut to size again.
class PaddedPair {
 public:
  /// @param max_disparity_px  the search covers 0 to at least this.
  PaddedPair(const cv::Mat& left, const cv::Mat& right, int max_disparity_px);

  const cv::Mat& left() const { return left_; }
  const cv::Mat& right() const { return right_; }

  /// Number of disparities searched, from 0 on: a multiple of 16, as OpenCV asks.
  int disparities() const { return disparities_; }

  /// The map of the images without padding, px, NaN = none.
  /// @param map  of the padded size in OpenCV's fixed point, 16 counts a pixel; negative = none.
  cv::Mat1f Crop(const cv::Mat1s& map) const;

 private:
  int disparities_;
  cv::Mat left_;
  cv::Mat right_;
};

/// The left map of a matcher, px, NaN = none.
/// @param matcher  set to pair.disparities(), from 0 on.
cv::Mat1f MatchPadded(cv::StereoMatcher& matcher, const PaddedPair& pair);

}  // namespace sprout

#endif  // SPROUT_SERVICES_EVALUATE_RIVALS_PADDED_PAIR_H_
