#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/rig.h"
#include "common/core/tof_image.h"
#include "services/tools/calibrate/board_view.h"
#include "services/tools/calibrate/calibrator.h"
#include "services/tools/calibrate/coverage.h"
#include "services/tools/calibrate/quality.h"
#include "services/tools/calibrate/scene/scene_refiner.h"

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

/// The result as text for a terminal: verdict and reasons, how the frames fit before and after, and
/// every number with its standard deviation.
std::string SceneSummaryText(const SceneRefinement& refinement);

/// What a refinement tells about the calibration with which it began: how the frames fit, and where
/// ToF points belong.
std::string SceneCheckText(const SceneRefinement& refinement, const RectifiedPair& pair);

/// The result as one HTML page with all its pictures: the same, and rows and ToF points before and
/// after.
std::string SceneReportHtml(const SceneRefinement& refinement, const SceneRefiner& refiner);

/// Where a camera saw corners: a dot each, from blue (no error) to red (4 standard deviations and
/// more), over the nine parts of the image, with a scale. O(corners).
cv::Mat3b CoveragePicture(const CameraQuality& quality, cv::Size size);

/// A rectified pair side by side with rows drawn across. O(pixels).
/// @param left, right  8UC1 or 8UC3, of one size.
cv::Mat3b PairPicture(const cv::Mat& left, const cv::Mat& right);

/// The ToF camera's points on the rectified left image, coloured by depth, near red, with a scale.
/// O(pixels).
/// @param tof  without the bias of the ranges.
cv::Mat3b TofPicture(const cv::Mat& left, const TofImage& tof, const Rig& rig);

/// Values at places of an image, a dot each, from blue (0) to red (most_px), with a scale.
/// O(pixels).
cv::Mat3b DotsPicture(const cv::Mat& image, const std::vector<cv::Point2d>& places,
                      const std::vector<double>& values_px, double most_px);

/// A verdict, as all reports have it.
std::string VerdictText(bool is_good);

/// The start of a report's page: its style, and the verdict with the reasons against the result.
/// @param what     of which the verdict is, "Calibration".
/// @param reasons  empty: it is good.
std::string ReportStart(std::string_view what, const std::vector<std::string>& reasons);

}  // namespace sprout::calibrate
