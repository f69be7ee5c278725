#pragma once

#include "common/config/config.h"
#include "common/inputs/findings.h"
#include "services/pipeline/pipeline.h"

namespace sprout {

/// Confidence and standard deviations for a pair that does not fit its calibration, which growth
/// cannot know. A right camera that is turned, scaled or moved so that its rows are off by e px
/// has columns that may be off as far: of disparities whose error is spread evenly up to e, 1 / e
/// are right to 1 px, and its standard deviation is e / √3. Where the images do not show one scene,
/// or left and right are not what they are said to be, no disparity is believed. Where range points
/// show it that are believed beside the pair, and no match is near, all stays as it is. What falls
/// below grow { min_confidence } has no disparity any more, what falls below that of depth { } no
/// depth. O(pixels).
/// @returns whether the pair does not fit: what a memory has of it is not to be believed, either.
bool BoundConfidence(const inputs::Findings& findings, const SproutConfig& config,
                     DepthFrame& depth);

}  // namespace sprout
