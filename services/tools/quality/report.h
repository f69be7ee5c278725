#ifndef SPROUT_SERVICES_TOOLS_QUALITY_REPORT_H_
#define SPROUT_SERVICES_TOOLS_QUALITY_REPORT_H_

#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "services/tools/quality/measurement.h"
#include "services/tools/quality/verdict.h"

namespace sprout::quality {

/// The whole measurement as a page that is one file: figures with limits and meanings, where it was
/// measured, the plane, residuals and noise as pictures and histograms. The same measurement gives
/// the same bytes.
/// @param input  what was measured. @pre !measurement.empty().
std::string ReportHtml(const Measurement& measurement, std::span<const Limit> limits,
                       const std::string& input);

// Pictures for people, as common/picture/picture.h makes them. @pre !measurement.empty().
// O(pixels).

/// The newest disparity map, with the region, and the edge, as white frames.
cv::Mat3b RegionPicture(const Measurement& measurement);

/// Picture of the region: depth less that of the plane, mean of the frames, mm. Green lies on the
/// plane, blue is nearer, red farther; the scale reaches to three times the RMS.
/// @param maps  the meter's.
cv::Mat3b ResidualPicture(const TargetMaps& maps, const TargetQuality& quality);

/// Picture of the region: standard deviation of each pixel over the frames, mm. The scale ends at
/// twice the 95 % figure.
cv::Mat3b NoisePicture(const TargetMaps& maps, const TargetQuality& quality);

}  // namespace sprout::quality

#endif  // SPROUT_SERVICES_TOOLS_QUALITY_REPORT_H_
