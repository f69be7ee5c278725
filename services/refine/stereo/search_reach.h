#pragma once

#include <string>

#include "common/config/config.h"
#include "common/geometry/projection.h"
#include "common/inputs/findings.h"

namespace sprout::refine {

/// The disparity of a point at infinity, rounded up, px; 0 where it is negative.
int InfinityPx(const RectifiedPair& pair);

/// Says that more than a tenth of what a pair shows is nearer than stereo looks, and the cure;
/// empty where that is not so, cannot be told, or no seeds come from stereo.
/// @param findings  of CheckInputs(), for this pair.
std::string BeyondSearch(const inputs::Findings& findings, const RefineConfig& config,
                         const RectifiedPair& pair);

}  // namespace sprout::refine
