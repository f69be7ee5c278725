#pragma once

#include <cstdint>

#include "services/grow/paper/growth_rule.h"

// The cost of one correspondence, computed directly; the kernels compute many at once.
namespace sprout::grow {

/// Costs of eq. (1), 1 − MNCC, and −ln of eqs. (4) and (6), for a rule's similarity.
/// @param q  of which both windows lie in the images. kExcludedCost where EPC finds no prior.
int32_t CostOf(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q);

/// The cost of any correspondence; kExcludedCost where a window leaves its image.
int32_t CostWhereItFits(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q);

/// Counts from d to the least cost (S2), at most kMaxStep; 0 if d does not have the smallest of
/// the costs of d − 1, d and d + 1, if one is missing, or the left window of the next pixel.
int SubPixelStep(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q);

}  // namespace sprout::grow
