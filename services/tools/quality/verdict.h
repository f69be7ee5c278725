#ifndef SPROUT_SERVICES_TOOLS_QUALITY_VERDICT_H_
#define SPROUT_SERVICES_TOOLS_QUALITY_VERDICT_H_

#include <span>
#include <string>

#include "services/tools/quality/limits.h"
#include "services/tools/quality/measurement.h"

namespace sprout::quality {

/// Whether every limit is kept; true without limits.
bool IsGood(const TargetQuality& quality, std::span<const Limit> limits);

/// The figures that were measured, a line each, and those that have a limit, with their limits and
/// whether these are kept. Begins with region and frames. @pre !measurement.empty().
std::string TableText(const Measurement& measurement, std::span<const Limit> limits);

/// The same for programs: figures by name, null where not measured. @param input  what was
/// measured.
std::string JsonText(const Measurement& measurement, std::span<const Limit> limits,
                     const std::string& input);

/// Why a figure may be missing that people look for, one line each; empty: none is.
std::string MissingText(const TargetQuality& quality, const TargetSettings& settings);

}  // namespace sprout::quality

#endif  // SPROUT_SERVICES_TOOLS_QUALITY_VERDICT_H_
