#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "services/pipeline/files/pair_reader.h"

namespace sprout {

/// The arguments of `sprout-pipeline files`.
struct FilesOptions {
  std::string left;  ///< see ListPairs()
  std::string right;
  std::string tof;                      ///< empty: none
  double max_spread_ms = kMaxSpreadMs;  ///< of files that are named after their times
  RigOptions rig;
  PixelOptions pixels;
  std::string out;                     ///< folder
  std::vector<std::string> only = {};  ///< some of kOutputs; none: all
  /// Disparities that are less sure are left out (grow.min_confidence), %; nothing: as configured.
  std::optional<double> min_confidence_percent = {};
};

/// Computes pairs of image files and writes the results, see README.md; those of a pair while the
/// next one is computed. Prints a line on stdout for each pair when it is written, or one on stderr
/// if it cannot be computed or written and is left out; and one on stderr if it was computed, but
/// something is wrong with it: CheckInputs() says so, a stage had nothing to give, or nothing has a
/// depth. That a memory forgot earlier frames is not wrong.
/// @returns exit code: 0; 1 when a pair was left out, or something is wrong with one, or `stop`
///          came.
/// @throws ConfigError, before anything is computed, for flags that cannot be used, and for
///         settings of depth { } that nothing here applies.
int RunFiles(const FilesOptions& options, SproutConfig config, const std::stop_token& stop);

}  // namespace sprout
