#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "common/inputs/feature_matches.h"

namespace sprout::inputs {

/// A length and its standard deviation, px.
struct Estimate {
  double value = 0;
  double sigma = 0;
};

/// The median of values and its standard deviation, as of normal deviates; 0 and 0 of none. O(n).
Estimate MedianOf(std::vector<double> values);

/// How many rows the right image lies lower than the left one, and which matches say so:
///
///   y' − y = a + b · x + c · y                      rows, roll, focal length       (1)
///   y' − y = a + b · x + c · y + d · (e + g · y)    and moves of the right camera  (2)
///   y' − y = a + b · x + c · y + h · x y + k · y² + l · y r²     and turns, lens distortion    (3)
///
/// with x, y from the middle in shares of the image's sides, d the disparity and r the distance
/// from the middle in shares of the width. The terms with d are 0 when the right camera stands
/// beside the left one at the same moment: a camera that moved between two exposures (or is mounted
/// further up or ahead than calibrated) sees near things displaced by more rows than far ones.
struct PairModel {
  std::vector<Match> inliers;  ///< matches that agree with (1) or (2)
  int tried = 0;               ///< matches
  /// Mean and standard deviation of the number of inliers that matches with random rows would have.
  Estimate by_chance;
  /// By (1): the rows in the middle of the image, and where they are most in 4 × 3 cells.
  Estimate middle_px;
  Estimate worst_px;
  /// By (3), where they are most; 0 and 0 of fewer than 80 matches.
  Estimate bent_px;
  double roll_rad = 0;  ///< of the right image, clockwise > 0
  /// By (1): by which share of their height things are larger in the right image.
  Estimate stretch;
  /// Root mean square over the inliers of what d · (e + g · y) adds to (1), and of its error.
  Estimate parallax_px;
};

/// Fits (1) by random samples of three matches, then (1), (2) and (3) by iterated weighted least
/// squares (Tukey's weights). The same matches give the same model.
/// @param size  of the images.
/// O(matches), about 0.2 ms for 400.
PairModel FitPair(const Matches& matches, cv::Size size);

}  // namespace sprout::inputs
