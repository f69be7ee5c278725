#pragma once

#include <string>
#include <vector>

#include "common/core/result.h"
#include "common/inputs/findings.h"
#include "services/tools/calibrate/scene/scene_refiner.h"

namespace sprout::calibrate {

/// Fewest matches on smooth surfaces of the ToF camera for its numbers to change.
inline constexpr int kMinTofMatches = 60;

/// The inverse depths that matches start with, 1/m.
std::vector<double> Depths(const std::vector<SceneMatch>& matches);

/// Whether frames show enough for a refinement: matches, over the image, at different depths. The
/// error says what is missing and what to do. O(matches).
/// @param left_px  of the matches, rectified.
Result<void> CheckScene(const std::vector<SceneRefiner::View>& views,
                        const std::vector<SceneMatch>& matches,
                        const std::vector<cv::Point2d>& left_px, const RectifiedPair& pair);

/// Whether one calibration fits all frames: otherwise they are of different scenes, or of different
/// times. O(matches).
Result<void> CheckAgreement(const std::vector<SceneMatch>& matches,
                            const std::vector<MatchResidual>& residuals, size_t views);

/// Why a refinement is not good, one line each.
std::vector<std::string> ReasonsAgainst(const SceneRefinement& refinement);

/// How far rows of the right image lie below those of the left one, before the refinement: medians
/// in equal cells of the left image, 3 rows of 4, px; NaN where there are fewer than 5 matches. A
/// roll of a camera shows as a slope from left to right, a wrong focal length as one from top to
/// bottom.
cv::Mat1f RowsOverImage(const SceneRefinement& refinement, const RectifiedPair& pair);

/// What has to be added to projected ToF points in the middle of the left image, px: the turn of
/// the ToF camera that the refinement found; NaN where the scene does not show it, or where the
/// refinement is not good.
cv::Point2d TofShift(const SceneRefinement& refinement, const RectifiedPair& pair);

/// Why the calibration with which a refinement began does not hold any more, one line each; empty:
/// it holds.
/// @param findings  of the inputs, all frames together.
std::vector<std::string> ReasonsToCalibrate(const SceneRefinement& refinement,
                                            const inputs::Findings& findings,
                                            const RectifiedPair& pair);

}  // namespace sprout::calibrate
