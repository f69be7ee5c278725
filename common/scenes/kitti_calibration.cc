#include "common/scenes/kitti_calibration.h"

#include <optional>
#include <sstream>
#include <string>

#include "common/core/number_text.h"
#include "common/scenes/calibration_lines.h"

namespace sprout::scenes {
namespace {

// Seven digits are written; more than their rounding is no rotation.
constexpr double kRotationTolerance = 1e-4;

// The "key: numbers" lines of a calibration.
CalibrationLines KittiLines(const std::filesystem::path& path) {
  return {path, ": ", "P2, P3, R0_rect and Tr_velo_to_cam"};
}

template <int kRows, int kCols>
Eigen::Matrix<double, kRows, kCols> Matrix(const CalibrationLines& file, const std::string& key) {
  const std::string allowed = std::to_string(kRows * kCols) + " finite numbers";
  Eigen::Matrix<double, kRows, kCols> matrix;
  std::istringstream words(file.Text(key));
  int count = 0;
  for (std::string word; words >> word; ++count) {
    const std::optional<double> number = ParseNumber<double>(word);
    if (!number || count == kRows * kCols) throw file.Bad(key, allowed);
    matrix(count / kCols, count % kCols) = *number;
  }
  if (count < kRows * kCols) throw file.Bad(key, allowed);
  return matrix;
}

Eigen::Matrix3d Rotation(const CalibrationLines& file, const std::string& key,
                         const Eigen::Matrix3d& matrix) {
  const double off = (matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (off < kRotationTolerance && matrix.determinant() > 0) return matrix;
  throw file.Bad(key, "a rotation");
}

RectifiedPair PairOf(const CalibrationLines& file, cv::Size size, const std::string& left_key,
                     const std::string& right_key) {
  const auto left = Matrix<3, 4>(file, left_key);
  const auto right = Matrix<3, 4>(file, right_key);
  if (!(left(0, 0) > 0)) throw file.Bad(left_key, "a focal length above 0");
  if (!AreRectified({left(0, 0), left(1, 1), left(1, 2)},
                    {right(0, 0), right(1, 1), right(1, 2)})) {
    throw file.Bad(right_key,
                   "one focal length for both cameras and axes, and " + left_key + "'s row");
  }
  if (!(left(0, 3) > right(0, 3))) {
    throw file.Bad(right_key, "a camera to the right of " + left_key + "'s");
  }
  RectifiedPair pair{.width = size.width, .height = size.height};
  pair.focal_px = left(0, 0);
  pair.cx = left(0, 2);
  pair.cy = left(1, 2);
  pair.cx_right = right(0, 2);
  pair.baseline_m = (left(0, 3) - right(0, 3)) / pair.focal_px;
  return pair;
}

// What KITTI calls the projections of its colour cameras, or of its grey ones.
struct ProjectionKeys {
  std::string left;
  std::string right;
};

ProjectionKeys KeysOf(const CalibrationLines& file, bool grey) {
  // The one pair of KITTI-360, in colour, has the names that grey ones have elsewhere.
  grey = grey || (file.Has("P_rect_00") && !file.Has("P_rect_02") && !file.Has("P2"));
  const std::string prefix = file.Has(grey ? "P_rect_00" : "P_rect_02") ? "P_rect_0" : "P";
  return {prefix + (grey ? "0" : "2"), prefix + (grey ? "1" : "3")};
}

RectifiedPair PairOf(const CalibrationLines& file, cv::Size size, bool grey) {
  const ProjectionKeys keys = KeysOf(file, grey);
  return PairOf(file, size, keys.left, keys.right);
}

// P = K · [I | t].
Eigen::Vector3d LeftOffset(const CalibrationLines& file, bool grey) {
  const auto left = Matrix<3, 4>(file, KeysOf(file, grey).left);
  const double z = left(2, 3);
  return {(left(0, 3) - left(0, 2) * z) / left(0, 0), (left(1, 3) - left(1, 2) * z) / left(0, 0),
          z};
}

}  // namespace

Eigen::Vector3d ReadKittiLeftOffset(const std::filesystem::path& path) {
  return LeftOffset(KittiLines(path), /*grey=*/false);
}

RectifiedPair ReadKittiPair(const std::filesystem::path& path, cv::Size size, bool grey) {
  return PairOf(KittiLines(path), size, grey);
}

PairCalibration OpenKittiPairs(const std::filesystem::path& path) {
  const CalibrationLines file = KittiLines(path);
  const auto pair_of = [file](cv::Size size, bool grey) { return PairOf(file, size, grey); };
  try {
    pair_of({}, /*grey=*/false);
  } catch (const ConfigError&) {
    if (!file.Has("P0") && !file.Has("P_rect_00")) throw;
    pair_of({}, /*grey=*/true);
  }
  return pair_of;
}

KittiCalibration ReadKittiSequenceCalibration(const std::filesystem::path& path, cv::Size size,
                                              bool grey) {
  const CalibrationLines file = KittiLines(path);
  KittiCalibration calibration{.pair = PairOf(file, size, grey)};
  if (!file.Has("Tr")) return calibration;
  const auto pose = Matrix<3, 4>(file, "Tr");
  calibration.left_from_scanner.linear() = Rotation(file, "Tr", pose.leftCols<3>());
  calibration.left_from_scanner.translation() = pose.col(3) + LeftOffset(file, grey);
  return calibration;
}

KittiCalibration ReadKittiRawCalibration(const std::filesystem::path& folder, cv::Size size,
                                         bool grey) {
  const CalibrationLines cameras = KittiLines(folder / "calib_cam_to_cam.txt");
  KittiCalibration calibration{.pair = PairOf(cameras, size, grey)};
  const CalibrationLines scanner = KittiLines(folder / "calib_velo_to_cam.txt");
  const Eigen::Matrix3d rectification =
      Rotation(cameras, "R_rect_00", Matrix<3, 3>(cameras, "R_rect_00"));
  calibration.left_from_scanner.linear() =
      rectification * Rotation(scanner, "R", Matrix<3, 3>(scanner, "R"));
  calibration.left_from_scanner.translation() =
      rectification * Matrix<3, 1>(scanner, "T") + LeftOffset(cameras, grey);
  return calibration;
}

KittiCalibration ReadKittiCalibration(const std::filesystem::path& path, cv::Size size) {
  const CalibrationLines file = KittiLines(path);
  KittiCalibration calibration{.pair = PairOf(file, size, /*grey=*/false)};
  const Eigen::Matrix3d rectification = Rotation(file, "R0_rect", Matrix<3, 3>(file, "R0_rect"));
  const auto pose = Matrix<3, 4>(file, "Tr_velo_to_cam");
  calibration.left_from_scanner.linear() =
      rectification * Rotation(file, "Tr_velo_to_cam", pose.leftCols<3>());
  calibration.left_from_scanner.translation() =
      rectification * pose.col(3) + LeftOffset(file, /*grey=*/false);
  return calibration;
}

}  // namespace sprout::scenes
