#pragma once

#include "common/config/config.h"
#include "common/core/tof_image.h"
#include "common/inputs/findings.h"
#include "services/pipeline/pipeline.h"

namespace sprout {

/// Believes nothing of a pair that shows two scenes, is swapped or has its columns moved, which
/// growth cannot know: the confidence becomes 0, and the standard deviation the largest. Then grow
/// { min_confidence } takes all disparities away, and depth { min_confidence } all depths.
/// O(pixels).
void BelieveNothing(const SproutConfig& config, DepthFrame& depth);

/// Leaves out ranges that would spoil what the pair shows: all if they are noise, hit nothing, have
/// another scale, lie farther aside than refine can move them, or are contradicted beside a pair by
/// which refine does not judge them. @returns a note for the user.
/// @param has_map_without  whether there is a map without ranges.
/// @param width  of the images.
std::string LeaveOutRanges(const inputs::Findings& findings, bool has_map_without, int width,
                           TofImage& tof);

}  // namespace sprout
