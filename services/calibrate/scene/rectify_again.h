#ifndef SPROUT_SERVICES_CALIBRATE_SCENE_RECTIFY_AGAIN_H_
#define SPROUT_SERVICES_CALIBRATE_SCENE_RECTIFY_AGAIN_H_

#include <opencv2/core.hpp>

#include "common/rig/rectification.h"

namespace sprout::calibrate {

/// A camera of a pair, and how its images are rectified.
struct RectifiedCamera {
  Lens lens;
  cv::Matx33d turn;  ///< from the camera's frame to the rectified one
  RectifiedPair pair;
  double cx = 0;  ///< of this camera's rectified images, px
};

/// An image that was rectified in one way, as another calibration of the same camera rectifies it:
/// bilinear. O(pixels).
/// @param image  8UC1 or 8UC3, of from.pair's size.
cv::Mat RectifyAgain(const cv::Mat& image, const RectifiedCamera& from, const RectifiedCamera& to);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_CALIBRATE_SCENE_RECTIFY_AGAIN_H_
