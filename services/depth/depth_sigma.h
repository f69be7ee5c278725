#ifndef SPROUT_SERVICES_DEPTH_DEPTH_SIGMA_H_
#define SPROUT_SERVICES_DEPTH_DEPTH_SIGMA_H_

#include <opencv2/core.hpp>

#include "common/core/depth_image.h"
#include "common/core/disparity_image.h"
#include "common/core/rig.h"

namespace sprout::depth {

/// Counts of a standard deviation in one of the depth itself: at half a metre the former is some
/// hundredths of a millimetre.
inline constexpr int kSigmaCountsPerDepthCount = 16;

/// Standard deviation of every depth of an image that DepthOf() made, eq. (D1), with the intrinsics
/// of that image and counts that are 16 times finer: rounded to nearest, at least 1, at most
/// kMaxDepthSigmaCounts; this also where that of the disparity is 15.94 px or more. 0 where there
/// is no depth. A pixel of a smaller image has that of the pixel of its block whose depth it has:
/// the one with the nearest disparity, of several the least sure. O(pixels), about 4
/// ns each.
///
/// @param disparity  that the depth was made of.
/// @param sigma      of the map's size, counts as in Part::kSigma.
/// @param pair       of the map's size.
/// @param scale      1, 2 or 4, as in DepthOf().
DepthImage DepthSigmaOf(const DepthImage& depth, const DisparityImage& disparity,
                        const cv::Mat1b& sigma, const RectifiedPair& pair, int scale);

}  // namespace sprout::depth

#endif  // SPROUT_SERVICES_DEPTH_DEPTH_SIGMA_H_
