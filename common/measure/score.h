#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"
#include "common/core/result.h"

namespace sprout {

// How a disparity map is scored against ground truth.
//
// Scored pixels: those that both cameras see (NonOccludedMask()) and whose true disparity is known.
// Error of a pixel: |d − d_gt|, px. A pixel without a disparity counts as wrong for every
// threshold. Ground truth: px, NaN or infinite = unknown.

/// Pixels of the left image that the right camera sees too: CV_8U, 255 = seen, else 0.
///
/// With a right truth: the disparity is known in both views and they agree,
/// |d_left(u, v) − d_right(u − d_left(u, v), v)| ≤ 1 px; the right map is read at the rounded
/// column.
///
/// Without one (`right_truth` empty) the left truth is warped into the right image: a pixel counts
/// when its disparity is known, its rounded right column lies in the image, and no other pixel of
/// its row with a disparity more than 1 px larger (a nearer surface) has the same right column.
/// An occlusion is missed where the nearer surface is so slanted that its pixels skip the column.
///
/// @returns an error when both maps are given and differ in size. O(pixels).
Result<cv::Mat1b> NonOccludedMask(const cv::Mat1f& left_truth, const cv::Mat1f& right_truth);

/// Pixels of the left image that a nearer surface hides from the right camera: CV_8U, 255 = hidden,
/// else 0. The disparity is known, its rounded right column lies in the image and (with a right
/// truth) is known there, and the pixel is not in NonOccludedMask(). Pixels of unknown truth, or
/// beyond the right image's border, are in neither mask.
/// @returns an error when both maps are given and differ in size. O(pixels).
Result<cv::Mat1b> OccludedMask(const cv::Mat1f& left_truth, const cv::Mat1f& right_truth);

/// Errors |d − d_gt| of a map, px: NaN where nothing is scored (`mask` is 0 or the truth unknown),
/// infinite where there is no disparity.
/// @param disparity_px  px, NaN or infinite = none.
/// @pre the three have one size. O(pixels).
cv::Mat1f ErrorMap(const cv::Mat1f& disparity_px, const cv::Mat1f& truth, const cv::Mat1b& mask);

/// How well a disparity map matches ground truth: counts of pixels, and figures made of them.
/// Shares are per cent of `scored` pixels and NaN when there are none; mean and root mean square
/// are over `with_disparity` pixels and NaN when there are none.
struct Accuracy {
  int64_t scored = 0;          ///< pixels in the mask with a known true disparity
  int64_t with_disparity = 0;  ///< scored pixels that have a disparity
  int64_t within_half = 0;     ///< with a disparity, error ≤ 0.5 px
  int64_t within_1 = 0;        ///< with a disparity, error ≤ 1 px
  int64_t below_1 = 0;         ///< with a disparity, error < 1 px
  int64_t within_2 = 0;        ///< with a disparity, error ≤ 2 px
  int64_t within_4 = 0;        ///< with a disparity, error ≤ 4 px
  int64_t within_d1 = 0;  ///< with a disparity, error ≤ 3 px or ≤ 5 % of the true disparity
  double sum_abs_px = 0;  ///< sum of errors, px
  double sum_squares_px2 = 0;  ///< sum of squared errors, px²

  double density_percent() const { return Percent(with_disparity); }
  double invalid_percent() const { return Percent(scored - with_disparity); }
  /// The headline figure: 100 − "total bad 1.0" of the Middlebury SDK.
  double correct_le1_percent() const { return Percent(within_1); }
  /// The stricter rule. Maps of whole pixels differ widely between the two rules, so tables show
  /// both.
  double correct_lt1_percent() const { return Percent(below_1); }
  /// Error > 0.5 px or no disparity ("total bad 0.5"): for sub-pixel truths.
  double bad05_percent() const { return Percent(scored - within_half); }
  /// Error > 2 px or no disparity ("total bad 2.0").
  double bad2_percent() const { return Percent(scored - within_2); }
  /// Error > 4 px or no disparity ("total bad 4.0").
  double bad4_percent() const { return Percent(scored - within_4); }
  /// KITTI's figure ("D1"): error > 3 px and > 5 % of the true disparity, or no disparity.
  double d1_percent() const { return Percent(scored - within_d1); }
  double mean_abs_px() const;
  double rms_px() const;

 private:
  double Percent(int64_t pixels) const;
};

/// Scores a map on the pixels where `mask` is not 0 and the truth is known. Thresholds are exact: a
/// map off by 1 px everywhere is all correct by ≤ and all wrong by <.
///
/// @param disparity_px  px, NaN or infinite = none. Rounding a map to counts changes its score
///                      against a truth of whole pixels (by up to +1.4 points for ≤ and −2.9 for <,
///                      measured): score a map as its method made it, not rounded.
/// @returns an error when the three sizes differ. O(pixels).
Result<Accuracy> Score(const cv::Mat1f& disparity_px, const cv::Mat1f& truth,
                       const cv::Mat1b& mask);

/// Scores a map in counts, as above.
Result<Accuracy> Score(const DisparityImage& disparity, const cv::Mat1f& truth,
                       const cv::Mat1b& mask);

}  // namespace sprout
