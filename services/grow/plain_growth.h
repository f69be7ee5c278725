#ifndef SPROUT_SERVICES_GROW_PLAIN_GROWTH_H_
#define SPROUT_SERVICES_GROW_PLAIN_GROWTH_H_

#include <span>

#include "services/grow/growth_rule.h"

namespace sprout::grow {

/// Alg. 1 as the paper prints it, every similarity from scratch: what runs for MNCC and EXPSSD, and
/// what the fast growth for EPC must give pixel by pixel. See Grower.
///
/// @param seeds  whose windows fit.
/// @returns disparities, one-to-one. About 0.3 µs a pixel. Works on OpenCV's threads.
DisparityImage GrowPlainly(const GrowthRule& rule, const GrowthInput& input,
                           std::span<const Correspondence> seeds);

/// Costs of eq. (1), 1 − MNCC, and of eqs. (4) and (6), exponents, for a rule's similarity.
/// @param q  of which both windows lie in the images. kExcludedCost where EPC finds no prior.
int32_t CostOf(const GrowthRule& rule, const GrowthInput& input, const Correspondence& q);

}  // namespace sprout::grow

#endif  // SPROUT_SERVICES_GROW_PLAIN_GROWTH_H_
