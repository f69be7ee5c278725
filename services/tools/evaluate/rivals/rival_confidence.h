#ifndef SPROUT_SERVICES_TOOLS_EVALUATE_RIVALS_RIVAL_CONFIDENCE_H_
#define SPROUT_SERVICES_TOOLS_EVALUATE_RIVALS_RIVAL_CONFIDENCE_H_

#include <opencv2/core.hpp>

#include "common/core/frame.h"

namespace sprout::evaluate {

// Other ways to rank the pixels of a map, from the same map and one of the right image. 8UC1 of its
// size, 0 where it has no disparity. They claim no probability. O(pixels).

/// The frame as its mirror image: the right image, mirrored, is the left one, and the seeds are
/// moved there, so that the chain gives the right image's map, mirrored. Seeds that only the left
/// camera sees are left out.
/// @pre frame has images, rig and seeds.
Frame Mirrored(const Frame& frame);

/// Left-right check: 255 / (1 + |d − d'|), with the right map's disparity d' (px) at u − d.
/// @param mirrored_px  map of Mirrored(), px, NaN = none.
cv::Mat1b LeftRightConfidence(const cv::Mat1f& map_px, const cv::Mat1f& mirrored_px);

/// What OpenCV's DisparityWLSFilter weights disparities with: variance of the map and left-right
/// check, with its defaults.
/// @param left  grey or BGR.
cv::Mat1b WlsConfidence(const cv::Mat& left, const cv::Mat1f& map_px, const cv::Mat1f& mirrored_px);

}  // namespace sprout::evaluate

#endif  // SPROUT_SERVICES_TOOLS_EVALUATE_RIVALS_RIVAL_CONFIDENCE_H_
