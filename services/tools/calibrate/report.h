#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_REPORT_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_REPORT_H_

#include <string>

#include "services/tools/calibrate/board_view.h"
#include "services/tools/calibrate/calibrator.h"
#include "services/tools/calibrate/view_collector.h"

namespace sprout::calibrate {

/// The result as text for a terminal: verdict and reasons, then a table.
std::string SummaryText(const Calibration& calibration);

/// How many images were used and left out, one line.
std::string CountsText(const ViewCounts& counts, size_t views);

/// The result as one HTML page with all its pictures: verdict first, then numbers with standard
/// deviations, where the corners were, the rectified pair with rows, and the ToF points on the left
/// image.
/// @param images  to show: what the cameras saw at one time.
std::string ReportHtml(const Calibration& calibration, const RigImages& images,
                       const std::string& counts_text);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_REPORT_H_
