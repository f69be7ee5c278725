#pragma once

#include <string>

#include "common/config/config.h"
#include "common/geometry/projection.h"
#include "common/inputs/findings.h"

namespace sprout::refine {

/// The disparity of a point at infinity, rounded up, px; 0 where it is negative.
int InfinityPx(const RectifiedPair& pair);

/// Says that more than a tenth of what a pair shows is nearer than stereo looks, and the cure;
/// empty where that is not so, cannot be told, ranges show it, or no seeds come from stereo.
/// @param findings    of CheckInputs(), for this pair.
/// @param has_ranges  which show what is near unless a finding says that they do not fit the
/// images.
std::string BeyondSearch(const inputs::Findings& findings, const RefineConfig& config,
                         const RectifiedPair& pair, bool has_ranges);

}  // namespace sprout::refine
