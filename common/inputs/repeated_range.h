#pragma once

#include "common/core/tof_image.h"

namespace sprout::inputs {

/// A range that many pixels have exactly, where all others are much less, or few have any one
/// beside it: what a sensor may say where it measures nothing (32.767 m, 10 m, 2.047 m ...), or a
/// flat wall.
struct RepeatedRange {
  float depth_m = 0;       ///< 0: there is none
  bool is_beyond = false;  ///< all others are much less
  int count = 0;           ///< pixels that have it
  int compared = 0;        ///< matches among their points in the picture
  int agreeing = 0;        ///< of them, with their disparity
  /// Whether all ranges are whole metres, though they are near: what is left without decimals.
  bool are_whole_m = false;

  /// Whether stereo does not see a wall there.
  bool MeansNothing() const;
};

/// Finds such a range by the range image alone: `compared` and `agreeing` stay 0. O(ToF pixels).
RepeatedRange FindRepeatedRange(const TofImage& tof);

}  // namespace sprout::inputs
