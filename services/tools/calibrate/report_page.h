#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_REPORT_PAGE_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_REPORT_PAGE_H_

#include <string>
#include <string_view>
#include <vector>

namespace sprout::calibrate {

/// A verdict, as all reports have it.
std::string VerdictText(bool is_good);

/// The start of a report's page: its style, and the verdict with the reasons against the result.
/// @param what     of which the verdict is, "Calibration".
/// @param reasons  empty: it is good.
std::string ReportStart(std::string_view what, const std::vector<std::string>& reasons);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_REPORT_PAGE_H_
