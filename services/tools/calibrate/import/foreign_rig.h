#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/core/pose.h"
#include "common/core/result.h"
#include "common/geometry/lens.h"
#include "common/rig/raw_rig.h"

namespace sprout::calibrate {

/// A camera as other programs describe it.
struct ForeignCamera {
  std::string name;  ///< in its file, for people: "cam0", "left.yaml"
  cv::Size size;     ///< px; 0×0: the file does not say
  Eigen::Matrix3d k = Eigen::Matrix3d::Zero();
  /// OpenCV's k1, k2, p1, p2, k3, k4, …, or k1 to k4 of its fisheye model (equidistant).
  std::vector<double> distortion;
  bool is_fisheye = false;
};

/// A pair as other programs describe it.
struct ForeignRig {
  ForeignCamera left;
  ForeignCamera right;
  /// The right camera in the left one's frame; lengths in the file's unit.
  Pose left_from_right;
  bool is_second_left = false;  ///< the second camera of its files stands on the left
};

/// A rectified camera's rotation (camera to rectified frame) and Tx (P[0, 3]) and f of its P.
struct ForeignRectification {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  double tx = 0;
  double focal_px = 0;
};

/// Where the right camera of a rectified pair stands: both rectified frames are parallel, and
/// b = (Tx − Tx') / f apart.
Pose PoseOfRectified(const ForeignRectification& left, const ForeignRectification& right);

/// Reads a pair from one file or two: OpenCV's YAML or XML of stereoCalibrate() (in one file, or
/// intrinsics and extrinsics apart as its samples write them), the same as PyYAML's lists, two
/// camera_info files of ROS, left and right, as camera_calibration writes them or `topic echo`
/// prints them, a camchain of Kalibr, or two sensor.yaml of EuRoC (of both the camera on the left
/// is the left one).
/// @throws ConfigError naming file and entry that cannot be used, or is missing, or the program
/// whose files are not read.
ForeignRig ReadForeignRig(const std::vector<std::filesystem::path>& files);

/// @param name  of the matrix, for people: "stereo.yml: R"
/// @throws ConfigError when it is scaled, a reflection, or no rotation for another reason.
void RequireRotation(const std::string& name, const Eigen::Matrix3d& matrix);

/// A camera with Brown's distortion, see FitBrown().
/// @returns an error when it is more than kWorstFitPx off anywhere, when its model does not have so
/// many coefficients, or when its matrix has a skew.
Result<LensFit> ToLens(const ForeignCamera& camera);
inline constexpr double kWorstFitPx = 0.1;

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
