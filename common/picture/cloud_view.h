#ifndef SPROUT_COMMON_PICTURE_CLOUD_VIEW_H_
#define SPROUT_COMMON_PICTURE_CLOUD_VIEW_H_

#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"
#include "common/core/rig.h"

namespace sprout {

/// The coloured point cloud of a disparity map, seen by a camera moved to the right and up: shows
/// at a glance whether surfaces are flat and edges clean.
///
/// @param disparity  px, of the size of the pair.
/// @param left       8UC1 grey or 8UC3 BGR image of that size.
/// @returns a picture of the pair's size, nearly black where there is no point. O(pixels).
cv::Mat3b CloudView(const RectifiedPair& pair, const DisparityImage& disparity,
                    const cv::Mat& left);

}  // namespace sprout

#endif  // SPROUT_COMMON_PICTURE_CLOUD_VIEW_H_
