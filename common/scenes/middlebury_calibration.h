#ifndef SPROUT_COMMON_SCENES_MIDDLEBURY_CALIBRATION_H_
#define SPROUT_COMMON_SCENES_MIDDLEBURY_CALIBRATION_H_

#include <filesystem>
#include <opencv2/core/types.hpp>

#include "common/core/rig.h"

namespace sprout::scenes {

/// Calibration of a 2005 or 2006 scene: f = 3740 px and b = 0.160 m at full size, the principal
/// point, which Middlebury does not give, in the centre of the image.
///
/// @param dmin_file  dmin.txt: disparity that was subtracted, px at full size.
/// @param missing_dmin_px  taken if there is no such file.
/// @param size       of the images, px.
/// @param scale      how many times smaller than full size they are, ≥ 1.
/// @throws ConfigError when dmin.txt is anything but one finite number.
RectifiedPair CalibrationFromDmin(const std::filesystem::path& dmin_file, double missing_dmin_px,
                                  cv::Size size, int scale);

/// Calibration of a 2014 scene: cam0 and cam1 (px), baseline (mm) of calib.txt. Other keys are
/// ignored, except that width and height, when given, must be those of the images: a calibration
/// for another resolution is the easiest mistake to make.
///
/// @param calib_file  calib.txt.
/// @param size        of the images, px.
/// @throws ConfigError for a missing file or key, a bad number, cameras that are not rectified.
RectifiedPair CalibrationFromCalib(const std::filesystem::path& calib_file, cv::Size size);

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_MIDDLEBURY_CALIBRATION_H_
