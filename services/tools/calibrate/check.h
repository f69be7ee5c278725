#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_CHECK_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_CHECK_H_

#include <filesystem>
#include <string>

namespace sprout::calibrate {

struct CheckOptions {
  std::filesystem::path input;  ///< a log, or a folder of unrectified images
  std::filesystem::path rig;    ///< to rectify raw images; empty: they are rectified already
  std::string prefix;
};

/// The subcommand check: checks a calibration with frames and prints the result, and if it is bad
/// the command that puts it right.
/// @returns exit code: 0 good, 1 calibrate again.
/// @throws LogError, ConfigError for files that cannot be used.
int RunCheck(const CheckOptions& options);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_CHECK_H_
