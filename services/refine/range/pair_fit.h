#pragma once

#include "services/refine/range/range_nodes.h"

namespace sprout::refine {

/// How well a pair fits around range points, at the best offset of each.
struct PairFit {
  double cost = 0;  ///< mean of (R4), 0 to 1; 0 if few points have clear texture
  /// Share of that cost which is saved by taking the right image's rows from a little above or
  /// below, in each block of the picture from where that is best, 0 to 1.
  double rows_gain = 0;
  /// The same from where that is best for all blocks together: not 0 if the right camera is turned
  /// or has another focal length, whose columns are off as well.
  double uneven_gain = 0;
  double most_rows_px = 0;  ///< the farthest of these best places, px
};

/// @param nodes  of that input.
/// O(nodes), at most 0.5 ms. No I/O; thread-safe; the same on every machine.
PairFit PairFitAt(const RangeInput& input, const RangeNodes& nodes);

}  // namespace sprout::refine
