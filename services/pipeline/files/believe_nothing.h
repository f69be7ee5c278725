#pragma once

#include "common/config/config.h"
#include "services/pipeline/pipeline.h"

namespace sprout {

/// Believes nothing of a pair that shows two scenes, is swapped or has its columns moved, which
/// growth cannot know: the confidence becomes 0, and the standard deviation the largest. Then grow
/// { min_confidence } takes all disparities away, and depth { min_confidence } all depths.
/// O(pixels).
void BelieveNothing(const SproutConfig& config, DepthFrame& depth);

}  // namespace sprout
