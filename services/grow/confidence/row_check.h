#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "services/grow/confidence/confidence.h"

namespace sprout::grow {

/// What the rows of the right image say of a map. Growth compares pixels of one row only, so the
/// place up and down where a match fits best is evidence that it has not used: on its own row if
/// the match is right, on any if not, and on other rows throughout if the pair is not rectified.
struct RowCheck {
  /// Share of the matches that are right, 0 to 1, with two standard deviations more than was
  /// found; 1 where too few can be asked.
  double right_share = 1;
  double claimed = 0;     ///< mean of the confidence at the same places, 0 to 1
  double columns_px = 0;  ///< how far columns may be off, as rows are; 0: not significantly
};

/// Asks at one corner of each of those of 20×15 parts of the picture where, with the parts beside,
/// range points are more than matches of stereo, so that the map depends on the ranges, whatever
/// the pair; or of the others.
/// @param confidence  of the filled map, 255 · (1 − p).
/// @param origin      of the seeds that are more. Of range points a glance at every fourth corner
/// may
///                    be enough: then nothing is said.
/// At most 1 ms on one core for both. No I/O; on OpenCV's threads, with the same result for any
/// number.
RowCheck CheckRows(const JudgedFrame& frame, const cv::Mat1b& confidence, SeedOrigin origin);

/// Bounds confidence and standard deviations by CheckRows(), eqs. (C4) and (C5) of the README.
/// @returns what was found, one line; empty: nothing, and all stays. O(pixels) where something is.
std::string BoundByRows(const JudgedFrame& frame, ConfidenceEstimator::Judgement& judgement);

}  // namespace sprout::grow
