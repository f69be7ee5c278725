#ifndef SPROUT_SERVICES_CALIBRATE_CHECK_H_
#define SPROUT_SERVICES_CALIBRATE_CHECK_H_

#include <filesystem>
#include <string>

namespace sprout::calibrate {

struct CheckOptions {
  std::filesystem::path log;
  std::filesystem::path
      rig;  ///< rectifies the log's unrectified images with it; empty: rectified ones
  std::string prefix;
};

/// The subcommand check: prints what a log tells about a calibration.
/// @returns exit code: 0 good, 1 has to be calibrated again.
/// @throws LogError, ConfigError for files that cannot be used.
int RunCheck(const CheckOptions& options);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_CALIBRATE_CHECK_H_
