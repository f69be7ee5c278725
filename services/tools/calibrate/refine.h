#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sprout::calibrate {

/// Of refine, and of check, which writes nothing: no out, report and also.
struct RefineOptions {
  std::vector<std::filesystem::path> inputs;  ///< logs, or folders of images
  std::filesystem::path rig;                  ///< empty: the calibration in the logs
  std::filesystem::path out;
  std::filesystem::path report;   ///< empty: none
  std::vector<std::string> also;  ///< of "focal", "row", "place", "yaw": members of SceneWishes
  std::string prefix;
  int bits = 0;  ///< of images in folders, see EightBits
};

/// The subcommand refine: refines a calibration from recordings of any scene.
/// @returns exit code: 0 good, 1 not good.
/// @throws LogError, ConfigError for files that cannot be used; std::runtime_error when they show
///         too little.
int RunRefine(const RefineOptions& options);

/// The subcommand check: a refinement that writes nothing. Prints whether the calibration with
/// which it begins still holds, and if not, the command that puts it right.
/// @returns exit code: 0 good, 1 calibrate again, or the scene shows too little to tell.
/// @throws as RunRefine().
int RunCheck(const RefineOptions& options);

}  // namespace sprout::calibrate
