#pragma once

#include <optional>
#include <string>

#include "common/core/seed.h"
#include "services/refine/refiner.h"

namespace sprout::refine {

/// One line for people: why a frame's answer is degenerate, since it has no seeds, or since its
/// range points or its images are not believed. Several reasons are joined by "; "; empty when
/// there is none.
/// @param refiner  after Compute(), which returned `seeds`.
/// @param stereo_seeds  whether stereo was asked for seeds.
std::string DegenerateText(const Refiner& refiner, const SeedSet& seeds, bool stereo_seeds);

/// One line for people: what was found of the range sensor in a frame that is answered, such as by
/// how much its points were moved. Empty for a sensor that is right; nothing when the images do not
/// show whether it is.
/// @param refiner  after Compute().
std::optional<std::string> FindingText(const Refiner& refiner);

/// `more` behind `text`, with "; " between the two if neither is empty.
std::string Joined(const std::string& text, const std::string& more);

}  // namespace sprout::refine
