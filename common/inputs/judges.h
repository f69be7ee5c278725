#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/core/rig.h"
#include "common/inputs/feature_matches.h"
#include "common/inputs/findings.h"
#include "common/inputs/pair_model.h"
#include "common/inputs/range_model.h"

// The judges of CheckInputs().
namespace sprout::inputs {

/// Grey levels, standard deviation: less than the noise of a camera that sees something.
inline constexpr double kBlankContrast = 1.5;

/// Answers Question::kBits by each image alone.
/// @param left, right  grey, of one size.
/// O(pixels), 0.1 to 2.4 ms; one thread.
Finding JudgeBits(const cv::Mat1b& left, const cv::Mat1b& right);

/// Whether one image is blurred, where too few corners have partners to compare contrasts by: then
/// it has less contrast on fine levels, and the less, the finer they are; other things have the
/// same less on all of them.
/// @returns a bad finding of Question::kContrast; nothing where that does not show. O(pixels).
std::optional<Finding> FindBlur(const cv::Mat1b& left, const cv::Mat1b& right);

/// Answers Question::kSides: whether the left image is the left one, and disparities begin at
/// infinity.
/// @param model   with inliers.
/// @param ranges  null when there is no range image.
Finding JudgeSides(const cv::Mat1b& left, const cv::Mat1b& right, const RectifiedPair& pair,
                   const PairModel& model, const RangeModel* ranges);

/// Whether so many matches agree that both images show one scene.
bool ShowOneScene(const PairModel& model);

/// How far columns of a pair may be off, px, by what its rows show: what turns, scales or bends
/// rows does so to columns. 0 where they show nothing bad.
double ColumnErrorPx(const PairModel& model, int width);

/// Findings kScene to kContrast, in their order.
/// @param ranges  null when there is no range image.
Findings JudgePair(const cv::Mat1b& left, const cv::Mat1b& right, const RectifiedPair& pair,
                   const Matches& matches, const PairModel& model, const RangeModel* ranges);

/// Findings kHits to kMoment, in their order.
/// @param ranges     null when there is no range image.
/// @param pair_fits  whether nothing about the pair is bad; otherwise only kHits is answered.
Findings JudgeRanges(const RangeModel* ranges, bool pair_fits);

/// Where points belong that fit when they are moved so far in the left image, px: "4 px further
/// left and 2 px further up".
std::string MoveText(const cv::Point2d& move_px);

}  // namespace sprout::inputs
