#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_REPORT_PICTURES_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_REPORT_PICTURES_H_

#include <opencv2/core.hpp>
#include <vector>

#include "common/core/rig.h"
#include "common/core/tof_image.h"
#include "services/tools/calibrate/quality.h"

namespace sprout::calibrate {

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

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_REPORT_PICTURES_H_
