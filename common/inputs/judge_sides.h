#pragma once

#include <opencv2/core.hpp>

#include "common/core/rig.h"
#include "common/inputs/findings.h"
#include "common/inputs/pair_model.h"
#include "common/inputs/range_model.h"

namespace sprout::inputs {

/// Answers Question::kSides: whether the left image is the left one, and disparities begin at
/// infinity.
/// @param model   with inliers.
/// @param ranges  null when there is no range image.
Finding JudgeSides(const cv::Mat1b& left, const cv::Mat1b& right, const RectifiedPair& pair,
                   const PairModel& model, const RangeModel* ranges);

}  // namespace sprout::inputs
