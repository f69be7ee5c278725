#pragma once

#include <vector>

namespace sprout {

/// What a horizontal laser scanner would measure: direction i has the angle (first + i) · step,
/// counted from the x axis (forward) to the left.
struct PlanarScan {
  std::vector<float> ranges_m;  ///< infinity where there is nothing
  int first = 0;                ///< number of the first direction; negative: right of forward
  double step_rad = 0;          ///< > 0

  bool operator==(const PlanarScan&) const = default;
};

}  // namespace sprout
