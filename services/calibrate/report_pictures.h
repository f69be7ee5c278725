#ifndef SPROUT_SERVICES_CALIBRATE_REPORT_PICTURES_H_
#define SPROUT_SERVICES_CALIBRATE_REPORT_PICTURES_H_

#include <opencv2/core.hpp>

#include "services/calibrate/board_view.h"
#include "services/calibrate/quality.h"

namespace sprout::calibrate {

/// Where a camera saw corners: a dot each, from blue (no error) to red (4 standard deviations and
/// more), over the nine parts of the image, with a scale. O(corners).
cv::Mat3b CoveragePicture(const CameraQuality& quality, cv::Size size);

/// The rectified pair side by side with rows drawn across. O(pixels).
cv::Mat3b PairPicture(const RawRig& rig, const RigImages& images);

/// The ToF camera's corrected points on the rectified left image, coloured by depth,
/// near red, with a scale. O(pixels).
cv::Mat3b TofPicture(const RawRig& rig, const RigImages& images);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_CALIBRATE_REPORT_PICTURES_H_
