#ifndef SPROUT_SERVICES_FINISH_GAP_FILLER_H_
#define SPROUT_SERVICES_FINISH_GAP_FILLER_H_

#include "common/config/config.h"
#include "common/core/disparity_image.h"

namespace sprout::grow {

/// Gap filling (paper, III): a pixel without disparity takes the median of the valid ones in its
/// 5×5 window (the lower one of two in the middle; the window ends at the image's border).
///
/// @param fill  NONE: returns the map; ONE_PASS: gaps look at the given map only; UNTIL_STABLE:
///              passes until nothing changes, so only an empty map keeps gaps. PRIOR: gaps take
///              the prior's disparity instead, then every pixel the median of its 5×5 window.
/// @param prior  of the map's size; only looked at by PRIOR. An empty one fills nothing.
/// @returns a new map (with NONE the given one); the given one is not changed. O(pixels), on
///          OpenCV's threads with the same result for any number.
DisparityImage FillGaps(const DisparityImage& map, GrowConfig::Fill fill,
                        const DisparityImage& prior);

}  // namespace sprout::grow

#endif  // SPROUT_SERVICES_FINISH_GAP_FILLER_H_
