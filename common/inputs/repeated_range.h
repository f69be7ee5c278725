#ifndef SPROUT_COMMON_INPUTS_REPEATED_RANGE_H_
#define SPROUT_COMMON_INPUTS_REPEATED_RANGE_H_

#include <vector>

#include "common/core/tof_image.h"
#include "common/geometry/projection.h"
#include "common/inputs/feature_matches.h"

namespace sprout::inputs {

/// The largest range, where many pixels have exactly this one and all others are much less: what a
/// sensor may say where it measures nothing (32.767 m, 65.534 m, 10 m ...), or a flat background.
struct RepeatedRange {
  float depth_m = 0;  ///< 0: there is none
  float next_m = 0;   ///< the largest of all other ranges
  int count = 0;      ///< pixels that have it
  int compared = 0;   ///< matches beside their points in the picture
  int agreeing = 0;   ///< of them, with their disparity
};

/// @param matches    with disparities that fit the pair.
/// @param projector  of the frame's calibration; tof has its size.
/// O(ToF pixels).
RepeatedRange FindRepeatedRange(const std::vector<Match>& matches, const TofImage& tof,
                                const TofProjector& projector);

}  // namespace sprout::inputs

#endif  // SPROUT_COMMON_INPUTS_REPEATED_RANGE_H_
