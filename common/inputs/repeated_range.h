#pragma once

#include "common/core/tof_image.h"

namespace sprout::inputs {

/// The largest range, where many pixels have exactly this one and all others are much less: what a
/// sensor may say where it measures nothing (32.767 m, 65.534 m, 10 m ...), or a flat background.
struct RepeatedRange {
  float depth_m = 0;  ///< 0: there is none
  float next_m = 0;   ///< the largest of all other ranges
  int count = 0;      ///< pixels that have it
  int compared = 0;   ///< matches among their points in the picture
  int agreeing = 0;   ///< of them, with their disparity
};

/// Without what matches say of it. O(ToF pixels).
RepeatedRange FindRepeatedRange(const TofImage& tof);

}  // namespace sprout::inputs
