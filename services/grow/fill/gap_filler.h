#pragma once

#include "common/config/config.h"
#include "common/core/disparity_image.h"

namespace sprout::grow {

/// Gap filling (paper, III): a pixel without disparity takes the median of the valid ones in its
/// 5×5 window (the lower one of two in the middle; the window ends at the image's border).
///
/// Keeps the memory of a frame for the next one, and its result as long as nobody else holds it, so
/// one object serves one caller at a time.
class GapFiller {
 public:
  /// @param fill  NONE: returns the map; ONE_PASS: medians use the given map only; PRIOR: gaps take
  ///              the prior's disparity, then every pixel takes the median of its 5×5 window.
  /// @param prior  of the map's size; only used by PRIOR. An empty one fills nothing.
  /// @returns another map (with NONE the given one); the given one is not changed. O(pixels), on
  ///          OpenCV's threads with the same result for any number.
  DisparityImage Fill(const DisparityImage& map, GrowConfig::Fill fill,
                      const DisparityImage& prior);

 private:
  DisparityImage filled_, other_;
};

}  // namespace sprout::grow
