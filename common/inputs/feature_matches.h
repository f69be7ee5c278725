#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace sprout::inputs {

/// A point of the scene in both images, px.
struct Match {
  cv::Point2d left;
  cv::Point2d right;

  double disparity() const { return left.x - right.x; }
  double rows() const { return right.y - left.y; }  ///< > 0: lower in the right image
};

/// What was found in one pair.
struct Matches {
  std::vector<Match> matches;
  int left_features = 0;  ///< corners that were searched for
  int right_features = 0;
  double step_px = 1;       ///< a pixel of the level that positions were measured on, px
  double most_rows_px = 0;  ///< that partners were searched up and down
};

/// Corners of the left image (FAST) with a partner in the right one, up to 3.5 % of the height (at
/// least 8 px) up or down and half the width to either side: the most similar one by normalised
/// cross-correlation, much more so than the second, and each other's. The position of the partner
/// is interpolated to a fraction of a pixel.
/// @param left, right  grey, of one size.
/// @param coarser  0: corners are searched on the finest level of the pyramid with at most 0.2 MP,
///                 and places measured one level finer. Else both on a level so much coarser.
/// O(pixels), about 1 ns each, and at most 1 ms; one thread; no I/O.
Matches MatchFeatures(const cv::Mat1b& left, const cv::Mat1b& right, int coarser);

}  // namespace sprout::inputs
