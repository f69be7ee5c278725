#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_RECTIFY_AGAIN_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_RECTIFY_AGAIN_H_

#include <opencv2/core.hpp>

#include "common/rig/bilinear_remap.h"
#include "common/rig/rectification.h"

namespace sprout::calibrate {

/// A camera of a pair, and how its images are rectified.
struct RectifiedCamera {
  Lens lens;
  cv::Matx33d turn;  ///< from the camera's frame to the rectified one
  RectifiedPair pair;
  double cx = 0;  ///< of this camera's rectified images, px
};

/// Turns images that were rectified in one way into those that another calibration of the same
/// camera makes. O(pixels), about a second at 2 MP: one for all images.
BilinearRemap RectifyAgain(const RectifiedCamera& from, const RectifiedCamera& to);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_RECTIFY_AGAIN_H_
