#ifndef SPROUT_SERVICES_CALIBRATE_SCENE_PAIR_MATCHES_H_
#define SPROUT_SERVICES_CALIBRATE_SCENE_PAIR_MATCHES_H_

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

/// Matches of a pair whose rows may be off by up to 5 % of the height: SIFT features (Lowe, IJCV
/// 2004), at most 60 in each of 8 × 6 cells of the left image, unique among those of the right
/// image on about the same row, and each other's best. Lucas and Kanade's method then finds the
/// position in the right image to some hundredths of a pixel, and has to find back.
/// @param left, right  grey, of one size; rectified by a calibration that may be slightly wrong.
/// About a second at 2 MP; on OpenCV's threads, with the same result for any number.
PairMatches MatchPair(const cv::Mat1b& left, const cv::Mat1b& right);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_CALIBRATE_SCENE_PAIR_MATCHES_H_
