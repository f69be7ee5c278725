#pragma once

#include <span>

#include "services/grow/paper/growth_rule.h"

namespace sprout::grow {

/// Matches the pixels that are not open, to which the prior leaves up to nine candidates: the rule
/// of the sweeps, step by step as the README numbers them. The fast sweep must give the same to the
/// byte.
///
/// @param seeds  whose windows fit.
/// @returns disparities, one-to-one; none at open pixels.
DisparityImage SweepPlainly(const GrowthRule& rule, const GrowthInput& input,
                            std::span<const Correspondence> seeds);

}  // namespace sprout::grow
