#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <functional>
#include <opencv2/core/types.hpp>

#include "common/core/rig.h"

namespace sprout::scenes {

/// Calibration of the colour cameras and the scanner in calib/ID.txt of KITTI's object set.
struct KittiCalibration {
  RectifiedPair pair;
  /// Transforms points of the scanner (m; x forward, y left, z up) to the left rectified frame.
  Eigen::Isometry3d left_from_scanner = Eigen::Isometry3d::Identity();
};

/// Reads the pair alone from any of KITTI's calibrations, also calib.txt of its sequences and
/// calib_cam_to_cam.txt of its raw drives: P2 and P3 (P_rect_02, P_rect_03), the colour cameras, or
/// with `grey` P0 and P1; P_rect_00 and P_rect_01 where there are no others (KITTI-360). See
/// ReadKittiCalibration().
RectifiedPair ReadKittiPair(const std::filesystem::path& file, cv::Size size, bool grey = false);

/// The calibration of a rectified pair, of a file that was read before.
/// @param size  of the images, px.
/// @param grey  KITTI's grey cameras (P0 and P1) instead of the coloured ones.
/// @throws ConfigError naming file and key, when the file has no such pair, or of another size.
using PairCalibration = std::function<RectifiedPair(cv::Size size, bool grey)>;

/// Reads the pairs of a file once; what ReadKittiPair() gives for any images.
/// @throws ConfigError when neither the colour cameras nor the grey ones can be used.
PairCalibration OpenKittiPairs(const std::filesystem::path& file);

/// Where the left camera is: what to add to a point in the frame of camera 0, m, by P2.
Eigen::Vector3d ReadKittiLeftOffset(const std::filesystem::path& file);

/// Reads P2, P3, R0_rect and Tr_velo_to_cam; other keys are ignored. P = K · [I | t] places the
/// cameras in the frame of camera 0, so a point is R0_rect · Tr_velo_to_cam · x + t of P2 in the
/// left one, and the baseline is (P2[0, 3] − P3[0, 3]) / f.
///
/// @param size  of the images, px.
/// @throws ConfigError naming file and key: missing, a wrong number of finite values, cameras that
///         are not rectified, an invalid rotation.
KittiCalibration ReadKittiCalibration(const std::filesystem::path& file, cv::Size size);

/// Reads calib.txt of an odometry sequence: P0 to P3, and Tr, which places the scanner in the
/// rectified camera 0. Without Tr there is no scanner, and its pose is none.
KittiCalibration ReadKittiSequenceCalibration(const std::filesystem::path& file, cv::Size size,
                                              bool grey);

/// Reads the two files of a day of raw drives: P_rect_00 to P_rect_03 and R_rect_00 of
/// calib_cam_to_cam.txt, R and T of calib_velo_to_cam.txt.
KittiCalibration ReadKittiRawCalibration(const std::filesystem::path& folder, cv::Size size,
                                         bool grey);

}  // namespace sprout::scenes
