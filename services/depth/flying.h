#pragma once

#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"

namespace sprout::depth {

/// When a point hangs between two surfaces. The values were chosen on maps with truth, see
/// NOTES.md.
struct FlyingRule {
  int reach_px = 6;    ///< how far a surface is at most
  double step_px = 1;  ///< how much nearer or farther, in disparity, it is at least
  double same_px = 1;  ///< up to this difference pixels belong to one surface
  /// Largest share of the pixels around, at most reach_px away, that belong to its surface: a ramp
  /// from one surface to another has few, a slanted surface many.
  double support = 0.2;
};

/// The pixels of a map that hang between two surfaces, as 255: along the row or the column there is
/// a nearer pixel on one side and a farther one on the other, and few pixels around have their
/// disparity. Kept are both edges of a step, thin objects in front of a surface, and slanted
/// surfaces up to 2 · same_px / (support · (2 reach_px + 1)) disparities a pixel: 0.77.
/// O(pixels), and O(reach_px²) for the pixels that are between two.
cv::Mat1b FindFlying(const DisparityImage& map, const FlyingRule& rule = {});

}  // namespace sprout::depth
