#ifndef SPROUT_SERVICES_PIPELINE_FILES_FILES_H_
#define SPROUT_SERVICES_PIPELINE_FILES_FILES_H_

#include <stop_token>
#include <string>

#include "common/config/config.h"
#include "services/pipeline/files/pair_reader.h"

namespace sprout {

/// What `sprout-pipeline files` was asked for.
struct FilesOptions {
  std::string left;  ///< see ListPairs()
  std::string right;
  std::string tof;  ///< empty: none
  RigOptions rig;
  std::string out;  ///< folder
};

/// Computes pairs of image files and writes what is found, see README.md; a line on stdout for
/// each, and on stderr for one that cannot be computed, which is left out.
/// @returns exit code: 0; 1 when a pair was left out, or `stop` came.
/// @throws ConfigError, before anything is computed, for flags that cannot be used.
int RunFiles(const FilesOptions& options, const SproutConfig& config, const std::stop_token& stop);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PIPELINE_FILES_FILES_H_
