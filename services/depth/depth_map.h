#ifndef SPROUT_SERVICES_DEPTH_DEPTH_MAP_H_
#define SPROUT_SERVICES_DEPTH_DEPTH_MAP_H_

#include "common/core/depth_image.h"
#include "common/core/disparity_image.h"
#include "common/core/rig.h"

namespace sprout::depth {

/// Depth of a disparity map, z = f·b / (d + cx_right − cx), in counts, rounded to nearest. No depth
/// where there is no disparity, where the depth is not positive, and beyond 65535 counts. A smaller
/// image has in each pixel the median depth of its block of scale × scale pixels (of an even number
/// the lower of the two in the middle), if at least half of the block has a depth; columns and rows
/// that do not fill a block are left out. O(pixels).
///
/// @param pair   of the map's size.
/// @param scale  1, 2 or 4; not larger than the image.
DepthImage DepthOf(const DisparityImage& disparity, const RectifiedPair& pair,
                   double metres_per_count, int scale);

}  // namespace sprout::depth

#endif  // SPROUT_SERVICES_DEPTH_DEPTH_MAP_H_
