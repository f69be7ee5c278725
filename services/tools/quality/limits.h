#ifndef SPROUT_SERVICES_TOOLS_QUALITY_LIMITS_H_
#define SPROUT_SERVICES_TOOLS_QUALITY_LIMITS_H_

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/measure/target_quality.h"

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

}  // namespace sprout::quality

#endif  // SPROUT_SERVICES_TOOLS_QUALITY_LIMITS_H_
