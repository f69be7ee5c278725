#pragma once

#include <opencv2/core.hpp>

#include "common/core/rig.h"
#include "common/scenes/dataset.h"
#include "common/scenes/tof_grid.h"

namespace sprout::scenes {

/// Renders the surfaces of the ground truth as seen by a ToF camera at another position.
///
/// Every pixel of a truth map becomes a small quadrilateral in space. Its corners take the mean
/// disparity of the pixels around them that belong to the same surface (within 1 px), so that
/// surfaces are closed, and end where the truth jumps. A z-buffer keeps the nearest. Surfaces that
/// the left camera does not see come from the right truth, and so do those more than 1.5 px of
/// disparity in front of the left one; elsewhere only the left truth is used, since two roundings
/// of one surface would interfere. A surface unknown in both views is missing: the camera sees
/// known surfaces behind it, else nothing.
///
/// @param rig    the truth's pair, and the ToF camera's real pose.
/// @param truth  left map, and right map or empty.
/// @param left, right  grey images of the pair; they give the albedo, grey / 255.
/// O(image pixels + samples), one thread.
TofSamples RenderSurface(const Rig& rig, const GroundTruth& truth, const cv::Mat1b& left,
                         const cv::Mat1b& right);

}  // namespace sprout::scenes
