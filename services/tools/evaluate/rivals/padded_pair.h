#pragma once

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

namespace sprout::evaluate {

/// OpenCV's matchers give no disparity to a band at the border, although most of its pixels are
/// seen by both cameras: as many columns as they search disparities on the left (matched from the
/// right image: on the right), and half a block all around. So that no method is penalised for
/// that, the images' borders are repeated outward that far, and the map is cut to size again.
class PaddedPair {
 public:
  /// Views that are matched.
  enum class Views { kLeft, kBoth };

  /// @param max_disparity_px  the search covers 0 to at least this.
  /// @param block             side of the matcher's window, px.
  PaddedPair(const cv::Mat& left, const cv::Mat& right, int max_disparity_px, int block,
             Views views = Views::kLeft);

  const cv::Mat& left() const { return left_; }
  const cv::Mat& right() const { return right_; }

  /// Number of disparities searched, from 0 on: a multiple of 16, as OpenCV asks.
  int disparities() const { return disparities_; }

  /// Any image of that size, padded as the pair is.
  cv::Mat Pad(const cv::Mat& image) const;

  /// The map of the images without padding, px, NaN = none.
  /// @param map  of the padded size in OpenCV's fixed point, 16 counts a pixel; negative = none.
  cv::Mat1f Crop(const cv::Mat1s& map) const;

 private:
  int disparities_;
  int margin_;  // rows above and below, and columns beside those for the search
  int columns_left_;
  int columns_right_;
  cv::Mat left_;
  cv::Mat right_;
};

/// The left map of a matcher, px, NaN = none.
/// @param matcher  set to pair.disparities(), from 0 on.
cv::Mat1f MatchPadded(cv::StereoMatcher& matcher, const PaddedPair& pair);

}  // namespace sprout::evaluate
