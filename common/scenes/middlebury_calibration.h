#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core/types.hpp>
#include <string>

#include "common/core/rig.h"
#include "common/scenes/dataset.h"
#include "common/scenes/kitti_calibration.h"

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
/// for another resolution is the easiest mistake to make; and doffs, when given, must be the
/// difference of the principal points to 1 px.
///
/// @param calib_file  calib.txt.
/// @param size        of the images, px.
/// @throws ConfigError for a missing file or key, one that is given twice, a bad number, a baseline
///         below 1 mm, cameras that are not rectified.
RectifiedPair CalibrationFromCalib(const std::filesystem::path& calib_file, cv::Size size);

/// Reads once the calibration of rectified pairs from a calib.txt of whoever wrote it: Middlebury
/// and ETH3D (cam0=, cam1=, baseline=; CalibrationFromCalib()) or KITTI (P2: and P3:, or P_rect_02:
/// and P_rect_03:; OpenKittiPairs()).
/// @throws ConfigError naming file and key, for all that is wrong whatever the images are.
PairCalibration OpenCalibFile(const std::filesystem::path& path);

/// One frame from a folder in Middlebury's layout, with the ToF camera simulated from the ground
/// truth: config.tof() = grid from the left one, sr4000 from both.
///
/// 2005 and 2006: view1 and view5 (left and right), disp1 (and disp5): 8-bit codes, disparity in
/// px = code / scale, 0 = unknown; dmin.txt may be missing. The scale is config.gt_scale(), or
/// follows from the height of the image (1110 rows = 1).
/// 2003: the same with im2, im6, disp2 and disp6; 1500 rows = 1, at most 4. Its focal length and
/// baseline are not published, so depth is not in metres.
/// 2014, 2021: im0 and im1, disp0.pfm (and disp1.pfm): px, inf = unknown; calib.txt.
/// The evaluation's (version 3) and ETH3D's two-view scenes: the same with disp0GT.pfm, and
/// mask0nocc.png, which may be missing.
/// Images end in .png, .jpg, .ppm or .pgm, of which the first that exists is read; alpha is
/// dropped.
///
/// Everything is read at once; Get() copies, so that callers cannot change the frame.
/// @throws ConfigError naming what is missing or wrong, and where.
std::unique_ptr<Dataset> OpenMiddlebury(const std::string& folder, const CaptureConfig& config);

}  // namespace sprout::scenes
