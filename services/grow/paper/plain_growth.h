#pragma once

#include <span>

#include "services/grow/paper/growth_rule.h"

namespace sprout::grow {

/// Growth that computes every similarity directly: the reference that the fast growth for EPC must
/// equal pixel by pixel, and what runs for MNCC and EXPSSD. Pixels that are not
/// open are swept (SweepPlainly()), then open ones grow by Alg. 1, with the order of seeds and the
/// bands of rows that Grower tells. Where all are open (preset paper, MNCC, EXPSSD) nothing is
/// swept.
///
/// @param seeds  whose windows fit.
/// @returns disparities, one-to-one. About 0.3 µs a pixel. Works on OpenCV's threads.
DisparityImage GrowPlainly(const GrowthRule& rule, const GrowthInput& input,
                           std::span<const Correspondence> seeds);

/// Matches the pixels that are not open, to which the prior leaves up to 15 candidates: the rule
/// of the sweeps, step by step as the README numbers them. The fast sweep must give the same to the
/// byte.
///
/// @param seeds  whose windows fit.
/// @returns disparities, one-to-one; none at open pixels.
DisparityImage SweepPlainly(const GrowthRule& rule, const GrowthInput& input,
                            std::span<const Correspondence> seeds);

}  // namespace sprout::grow
