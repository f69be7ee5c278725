#pragma once

#include <span>

#include "common/core/rig.h"
#include "common/geometry/projection.h"

namespace sprout::refine {

/// Adds to the points' sigma_px what depths in coarse steps err alike, as of 8 bits: that of an
/// even distribution over a step, less that over a px, within which the images find the rest.
/// Depths that are not all from few values change nothing.
/// @param tof  the range image of the points.
/// O(points). No I/O; one thread; the same on every machine.
void AddStepSigma(const RectifiedPair& pair, const TofImage& tof, std::span<ProjectedPoint> points);

}  // namespace sprout::refine
