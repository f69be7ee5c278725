#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "common/inputs/findings.h"
#include "common/inputs/range_model.h"

namespace sprout::inputs {

/// Findings kHits to kMoment, in their order.
/// @param ranges     null when there is no range image.
/// @param pair_fits  whether nothing about the pair is bad; otherwise only kHits is answered.
Findings JudgeRanges(const RangeModel* ranges, bool pair_fits);

/// Where points belong that fit when they are moved so far in the left image, px: "4 px further
/// left and 2 px further up".
std::string MoveText(const cv::Point2d& move_px);

}  // namespace sprout::inputs
