#ifndef SPROUT_COMMON_INPUTS_JUDGE_RANGES_H_
#define SPROUT_COMMON_INPUTS_JUDGE_RANGES_H_

#include "common/inputs/findings.h"
#include "common/inputs/range_model.h"

namespace sprout::inputs {

/// Findings kHits to kMoment, in their order.
/// @param ranges     null when there is no range image.
/// @param pair_fits  whether nothing about the pair is bad; otherwise only kHits is answered.
Findings JudgeRanges(const RangeModel* ranges, bool pair_fits);

}  // namespace sprout::inputs

#endif  // SPROUT_COMMON_INPUTS_JUDGE_RANGES_H_
