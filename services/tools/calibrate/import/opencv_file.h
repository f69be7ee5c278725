#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_IMPORT_OPENCV_FILE_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_IMPORT_OPENCV_FILE_H_

#include <filesystem>
#include <string>
#include <vector>

#include "services/tools/calibrate/import/foreign_rig.h"

namespace sprout::calibrate {

/// A file, and what is in it.
struct ForeignFile {
  std::filesystem::path path;
  std::string text;
};

/// Whether cv::FileStorage has written it: YAML, XML or JSON.
bool IsOpencvFile(const ForeignFile& file);

/// The pair of all entries of the files together. Entries are known by the names that OpenCV's
/// samples, its manual, and common programs give them: M1 or cameraMatrix1 or LEFT.K, D1, R, T, or
/// R1, P1, R2, P2 instead of R and T; image_width, image_height or imageSize.
/// @throws ConfigError naming what is missing, with the names that are known and those there are.
ForeignRig ReadOpencvRig(const std::vector<ForeignFile>& files);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_IMPORT_OPENCV_FILE_H_
