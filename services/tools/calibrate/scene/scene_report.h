#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_SCENE_REPORT_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_SCENE_REPORT_H_

#include <string>

#include "services/tools/calibrate/scene/scene_refiner.h"

namespace sprout::calibrate {

/// The result as text for a terminal: verdict and reasons, how the frames fit before and after, and
/// every number with its standard deviation.
std::string SceneSummaryText(const SceneRefinement& refinement);

/// What a refinement tells about the calibration with which it began: how the frames fit, and where
/// ToF points belong.
std::string SceneCheckText(const SceneRefinement& refinement, const RectifiedPair& pair);

/// The result as one HTML page with all its pictures: the same, and rows and ToF points before and
/// after.
std::string SceneReportHtml(const SceneRefinement& refinement, const SceneRefiner& refiner);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_SCENE_SCENE_REPORT_H_
