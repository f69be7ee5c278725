#pragma once

#include "common/config/config.h"
#include "common/inputs/findings.h"
#include "services/pipeline/pipeline.h"

namespace sprout {

/// Bounds confidence and standard deviations of a pair that does not fit its calibration, which
/// growth cannot know: eq. (F1) of the README, with e px by which rows, and so perhaps columns, are
/// off. Where the images do not show one scene, or are swapped, no disparity is believed. Both stay
/// where range points that are believed beside the pair show the disparity, and no match is near.
/// Then grow { min_confidence } takes disparities away, and depth { min_confidence } depths.
/// @param findings  of CheckInputs(), for this pair.
/// @param depth     of this pair; changed only if the pair does not fit.
/// @returns whether the pair does not fit: then it is not to be fused with others, either.
/// O(pixels).
bool BoundConfidence(const inputs::Findings& findings, const SproutConfig& config,
                     DepthFrame& depth);

}  // namespace sprout
