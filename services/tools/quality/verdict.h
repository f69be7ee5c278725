#ifndef SPROUT_SERVICES_TOOLS_QUALITY_VERDICT_H_
#define SPROUT_SERVICES_TOOLS_QUALITY_VERDICT_H_

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/measure/target_quality.h"
#include "services/tools/quality/measurement.h"

namespace sprout::quality {

/// What a figure has to keep.
struct Limit {
  const TargetFigure* figure = nullptr;
  std::optional<double> at_least;  ///< in the figure's unit; one of the two or both
  std::optional<double> at_most;

  /// Both ends are good; a figure that was not measured is not.
  bool IsKept(const TargetQuality& quality) const;

  /// ">= 98", "<= 0.5", "-1 to 1".
  std::string Text() const;
};

/// Reads a file of TargetLimits (common/measure/target_limits.proto).
/// @throws ConfigError for a file that cannot be read, an unknown figure, a figure that has two
///         limits, bounds that are missing, no numbers or the wrong way round, and no limit at all.
std::vector<Limit> LoadLimits(const std::filesystem::path& path);

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
