#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_RECTIFY_IMAGES_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_RECTIFY_IMAGES_H_

#include "common/core/result.h"
#include "common/rig/rectifier.h"
#include "services/tools/calibrate/board_view.h"

namespace sprout::calibrate {

/// A triplet as the cameras gave it, rectified, and without the bias of its ranges. O(pixels).
/// @returns an error when sizes do not fit the calibration.
Result<RigImages> RectifyImages(const Rectifier& rectifier, const RigImages& images);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_RECTIFY_IMAGES_H_
