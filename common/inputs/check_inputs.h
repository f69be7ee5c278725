#pragma once

#include <opencv2/core.hpp>

#include "common/core/rig.h"
#include "common/core/tof_image.h"
#include "common/geometry/projection.h"
#include "common/inputs/findings.h"

namespace sprout::inputs {

/// Asks of one frame whether its parts fit each other (README.md): one finding a question. From
/// a few hundred sparse matches of the pair (FAST corners) that are searched over ± 3.5 % of the
/// rows, and range points around them. Knows this frame alone; Combine() joins those of several.
/// @param left, right  rectified pair, 8UC1 or 8UC3 (BGR).
/// @param tof          range image; 0×0: none, its questions cannot be answered.
/// @param rig          calibration.
/// @returns "cannot tell" for all, with the reason, when sizes do not fit the calibration.
/// About 5 ms at 2 MP on one thread, three times that where much is bad (NOTES.md); the other
/// overload also saves the projector, O(ToF pixels). No I/O; the same findings for the same input.
Findings CheckInputs(const cv::Mat& left, const cv::Mat& right, const TofImage& tof,
                     const Rig& rig);

/// @param projector  of the frame's calibration; null when tof is 0×0.
Findings CheckInputs(const cv::Mat1b& left, const cv::Mat1b& right, const TofImage& tof,
                     const RectifiedPair& pair, const TofProjector* projector);

}  // namespace sprout::inputs
