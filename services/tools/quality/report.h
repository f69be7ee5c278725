#ifndef SPROUT_SERVICES_TOOLS_QUALITY_REPORT_H_
#define SPROUT_SERVICES_TOOLS_QUALITY_REPORT_H_

#include <span>
#include <string>

#include "services/tools/quality/limits.h"
#include "services/tools/quality/measurement.h"

namespace sprout::quality {

/// The whole measurement as a page that is one file: figures with limits and meanings, where it was
/// measured, the plane, residuals and noise as pictures and histograms. The same measurement gives
/// the same bytes.
/// @param input  what was measured. @pre !measurement.empty().
std::string ReportHtml(const Measurement& measurement, std::span<const Limit> limits,
                       const std::string& input);

}  // namespace sprout::quality

#endif  // SPROUT_SERVICES_TOOLS_QUALITY_REPORT_H_
