#ifndef SPROUT_SERVICES_TOOLS_CALIBRATE_IMPORT_YAML_FILE_H_
#define SPROUT_SERVICES_TOOLS_CALIBRATE_IMPORT_YAML_FILE_H_

#include <vector>

#include "services/tools/calibrate/import/foreign_rig.h"
#include "services/tools/calibrate/import/opencv_file.h"

namespace sprout::calibrate {

/// The pair of a camchain of Kalibr (one file with cam0 and cam1), or of two camera_info files of
/// ROS's camera_calibration, left and right.
/// @throws ConfigError naming file and entry that cannot be used, or is missing.
ForeignRig ReadYamlRig(const std::vector<ForeignFile>& files);

}  // namespace sprout::calibrate

#endif  // SPROUT_SERVICES_TOOLS_CALIBRATE_IMPORT_YAML_FILE_H_
