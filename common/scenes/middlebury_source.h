#ifndef SPROUT_COMMON_SCENES_MIDDLEBURY_SOURCE_H_
#define SPROUT_COMMON_SCENES_MIDDLEBURY_SOURCE_H_

#include <memory>
#include <string>

#include "common/scenes/dataset.h"

namespace sprout::scenes {

/// One frame from a folder in Middlebury's layout, with the ToF camera simulated from the ground
/// truth: config.tof() = grid from the left one, sr4000 from both.
///
/// 2005 and 2006: view1 and view5 (left and right), disp1 (and disp5): 8-bit codes, disparity in
/// px = code / scale, 0 = unknown; dmin.txt may be missing. The scale is config.gt_scale(), or
/// follows from the height of the image (1110 rows = 1).
/// 2003: the same with im2, im6, disp2 and disp6; 1500 rows = 1, at most 4. Its focal length and
/// baseline are not published, so depth is not in metres.
/// 2014, 2021: im0 and im1, disp0.pfm (and disp1.pfm): px, inf = unknown; calib.txt.
/// The evaluation's (version 3) and ETH3D's two-view scenes: the same with disp0GT.pfm, and
/// mask0nocc.png, which may be missing.
/// Images end in .png, .jpg or .ppm, of which the first that exists is read; alpha is dropped.
///
/// Everything is read at once; Get() copies, so that callers cannot change the frame.
/// @throws ConfigError naming what is missing or wrong, and where.
std::unique_ptr<Dataset> OpenMiddlebury(const std::string& folder, const CaptureConfig& config);

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_MIDDLEBURY_SOURCE_H_
