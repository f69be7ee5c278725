#pragma once

#include <cstdint>

namespace sprout {

/// What sprout-depth left out of a frame, in pixels. A pixel counts for the first rule, in the
/// order of the members, that leaves it out.
struct DepthCounts {
  int32_t pixels = 0;   ///< with a disparity, before any rule
  int32_t near = 0;     ///< nearer than min_m
  int32_t far = 0;      ///< farther than max_m
  int32_t outside = 0;  ///< outside the region or the box
  int32_t unsure = 0;   ///< of a confidence below min_confidence
  int32_t flying = 0;   ///< between two surfaces

  int32_t LeftOut() const { return near + far + outside + unsure + flying; }
  bool operator==(const DepthCounts&) const = default;
};

}  // namespace sprout
