#ifndef SPROUT_COMMON_SCENES_TOF_GRID_H_
#define SPROUT_COMMON_SCENES_TOF_GRID_H_

#include <opencv2/core.hpp>

#include "common/core/rig.h"
#include "common/core/tof_image.h"

namespace sprout::scenes {

/// A ToF camera at the left camera's position whose pixel (i, j) looks exactly through left pixel
/// (i·step + step/2, j·step + step/2), integer division: the paper's simulated sensor. Of size
/// floor(width / step) × floor(height / step), without lens distortion.
///
/// @param step_px  grid spacing in the left image, px.
/// @throws ConfigError when the grid would have no point: step_px < 1 or larger than the image.
TofCamera TofGridCamera(const RectifiedPair& pair, int step_px);

/// What the camera of TofGridCamera() measures: the depth of the true disparity at each grid
/// point, without noise; NaN where the disparity is unknown or its depth is not positive and
/// finite. The amplitude stays empty: it depends on the scene's infrared reflectance, which is
/// unknown.
///
/// @param left_disparity  px, of the size of the pair's images; NaN = unknown.
/// O(ToF pixels).
TofImage SampleTofGrid(const RectifiedPair& pair, int step_px, const cv::Mat1f& left_disparity);

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_TOF_GRID_H_
