#ifndef SPROUT_SERVICES_CALIBRATE_CHECK_H_
#define SPROUT_SERVICES_CALIBRATE_CHECK_H_

#include <filesystem>
#include <string>

namespace sprout::calibrate {

struct CheckOptions {
  std::filesystem::path log;
  std::filesystem::path
      rig;  ///< to rectify the log's raw images; empty: they are rectified already
  std::string prefix;
};

/// The subcommand check: checks a calibration with the frames of a log and prints the result.
/// @returns exit code: 0 good, 1 calibrate again.
/// @throws LogError, ConfigError for files that cannot be used.
int RunCheck(const CheckOptions& options);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_CALIBRATE_CHECK_H_
