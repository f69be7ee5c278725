#ifndef SPROUT_COMMON_SCENES_CALIB_FILE_H_
#define SPROUT_COMMON_SCENES_CALIB_FILE_H_

#include <filesystem>
#include <opencv2/core/types.hpp>

#include "common/core/rig.h"

namespace sprout::scenes {

/// Reads the calibration of a rectified pair from a calib.txt of whoever wrote it: Middlebury and
/// ETH3D (cam0=, cam1=, baseline=; CalibrationFromCalib()) or KITTI (P2: and P3:, or P_rect_02: and
/// P_rect_03:; ReadKittiPair()).
/// @param size  of the images, px.
/// @param grey  KITTI's grey cameras (P0 and P1) instead of the coloured ones.
/// @throws ConfigError naming file and key.
RectifiedPair ReadCalibFile(const std::filesystem::path& path, cv::Size size, bool grey);

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_CALIB_FILE_H_
