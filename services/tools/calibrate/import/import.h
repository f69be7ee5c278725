#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sprout::calibrate {

struct ImportOptions {
  std::vector<std::filesystem::path> files;  ///< see ReadForeignRig()
  std::filesystem::path rig = {};            ///< whose devices are kept; empty: none
  std::filesystem::path out;
  std::string size = {};  ///< WxH of the images, px, where the files do not say; else empty
  std::string unit = {};  ///< of lengths: "m", "cm", "mm"; empty: m, if that can be
  bool fisheye = false;   ///< OpenCV's fisheye model, which its files do not name
};

/// The subcommand import: makes a rig file of another program's calibration, and prints it.
/// @returns exit code 0.
/// @throws ConfigError for what cannot be used.
int RunImport(const ImportOptions& options);

}  // namespace sprout::calibrate
