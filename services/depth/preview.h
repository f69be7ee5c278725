#pragma once

#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"
#include "common/core/rig.h"

namespace sprout::depth {

/// Longest side of either image in a preview, px.
inline constexpr int kMaxPreviewSide = 640;

/// The left image and, to its right, the disparity map in colours with a scale in px and m; either
/// under a title, on white. Both are reduced by the same whole number, so that neither side is
/// longer than kMaxPreviewSide: a pixel of the image is the mean of a block, one of the map the
/// disparity in its middle. The colour scale spans the values of this frame. O(pixels).
///
/// @param left  8UC1 or 8UC3 (BGR), of the map's size, not empty.
/// @param pair  of the map's size.
cv::Mat3b PreviewOf(const cv::Mat& left, const DisparityImage& disparity,
                    const RectifiedPair& pair);

}  // namespace sprout::depth
