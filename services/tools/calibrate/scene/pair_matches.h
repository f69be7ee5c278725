#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace sprout::calibrate {

/// A point of the scene in both images of a pair, px.
struct PairMatch {
  cv::Point2d left;
  cv::Point2d right;
};

/// What was found in one pair.
struct PairMatches {
  std::vector<PairMatch> matches;  ///< in the order of the left image's cells
  int left_features = 0;           ///< of which they were searched
  int right_features = 0;
};

/// How thoroughly a pair is searched. The position of a match is as accurate in any case.
struct MatchEffort {
  int shrink = 1;           ///< features are searched in images of a so many times smaller side
  size_t max_in_cell = 60;  ///< features of each of 8 × 6 cells of the left image
};

/// Matches of a pair whose rows may be off by up to 5 % of the height: SIFT features (Lowe, IJCV
/// 2004), unique among those of the right image on about the same row, and each other's best. Lucas
/// and Kanade's method then finds the position in the right image to some hundredths of a pixel,
/// and has to find back.
/// @param left, right  grey, of one size; rectified by a calibration that may be slightly wrong.
/// About a second at 2 MP, with 2 and 20 a sixth of it; on OpenCV's threads, with the same result
/// for any number.
PairMatches MatchPair(const cv::Mat1b& left, const cv::Mat1b& right,
                      const MatchEffort& effort = {});

}  // namespace sprout::calibrate
