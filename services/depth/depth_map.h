#pragma once

#include <opencv2/core.hpp>

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

/// The limit of those depths, m.
inline double FarthestDepthM(double metres_per_count) { return 65535.5 * metres_per_count; }

/// How many pixels of a map have a depth that is farther. O(pixels).
int CountTooFar(const DisparityImage& disparity, const RectifiedPair& pair, double farthest_m);

/// Counts of a standard deviation in one of the depth itself: at half a metre the former is some
/// hundredths of a millimetre.
inline constexpr int kSigmaCountsPerDepthCount = 16;

/// Standard deviation of every depth of an image that DepthOf() made, eq. (D1), with the intrinsics
/// of that image and counts that are 16 times finer: rounded to nearest, at least 1, at most
/// kMaxDepthSigmaCounts; this also where that of the disparity is 15.94 px or more. 0 where there
/// is no depth. A pixel of a smaller image has that of the pixel of its block whose depth it has:
/// the one with the nearest disparity, of several the least sure. O(pixels), about 4 ns each.
///
/// @param disparity  that the depth was made of.
/// @param sigma      of the map's size, counts as in Part::kSigma.
/// @param pair       of the map's size.
/// @param scale      1, 2 or 4, as in DepthOf().
DepthImage DepthSigmaOf(const DepthImage& depth, const DisparityImage& disparity,
                        const cv::Mat1b& sigma, const RectifiedPair& pair, int scale);

}  // namespace sprout::depth
