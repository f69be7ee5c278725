#pragma once

#include <opencv2/core.hpp>

#include "common/core/rig.h"
#include "common/inputs/feature_matches.h"
#include "common/inputs/findings.h"
#include "common/inputs/pair_model.h"
#include "common/inputs/range_model.h"

namespace sprout::inputs {

/// Whether so many matches agree that both images show one scene.
bool ShowOneScene(const PairModel& model);

/// How far columns of a pair may be off, px, by what its rows show: what turns, scales or bends
/// rows does so to columns. 0 where they show nothing bad.
double ColumnErrorPx(const PairModel& model, int width);

/// Findings kScene to kContrast, in their order.
/// @param ranges  null when there is no range image.
Findings JudgePair(const cv::Mat1b& left, const cv::Mat1b& right, const RectifiedPair& pair,
                   const Matches& matches, const PairModel& model, const RangeModel* ranges);

}  // namespace sprout::inputs
