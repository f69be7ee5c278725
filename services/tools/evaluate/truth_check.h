#pragma once

#include <string>

#include "services/tools/evaluate/scene.h"

namespace sprout::evaluate {

/// Says when the ground truth does not fit the images, so that a score says nothing: as ranges of a
/// sensor in the left camera's place it is wrong (inputs::CheckInputs()), of another scale, picture
/// or view, or upside down. And when fewer than 75 % of a recorded scan's points on pixels with a
/// known truth lie within 1 px of it (KITTI 2015: 86 to 99 %): the calibration is that of another
/// recording. One whose focal length is off by 0.4 % is not noticed. Empty when all is well.
/// @param scanner  of the scan in `frame.tof` that the truth was made of; null: there is none.
/// O(pixels).
std::string WrongTruthText(const scenes::DatasetFrame& frame, const RectifiedPair& pair,
                           const TofProjector* scanner = nullptr);

/// The same of a scene.
std::string WrongTruthText(const Scene& scene);

}  // namespace sprout::evaluate
