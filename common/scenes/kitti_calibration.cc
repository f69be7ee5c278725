#include "common/scenes/kitti_calibration.h"

#include <map>
#include <optional>
#include <sstream>
#include <string>

#include "common/config/config_error.h"
#include "common/core/input_files.h"
#include "common/core/number_text.h"
#include "common/core/read_text.h"
#include "common/scenes/rectified.h"

namespace sprout::scenes {
namespace {

// Seven digits are written; more than their rounding is no rotation.
constexpr double kRotationTolerance = 1e-4;

// The "key: numbers" lines of a calibration.
class KittiCalibFile {
 public:
  explicit KittiCalibFile(const std::filesystem::path& path) : path_(path) {
    NoteInputFile(path);
    const Result<std::string> text = ReadText(path);
    if (!text) {
      throw ConfigError("calibration " + path.string() + ": " + text.error().text +
                        "; allowed: a file with P2, P3, R0_rect and "
                        "Tr_velo_to_cam");
    }
    std::istringstream lines(*text);
    for (std::string line; std::getline(lines, line);) {
      const size_t colon = line.find(':');
      if (colon == std::string::npos) continue;
      values_[std::string(Trimmed(line.substr(0, colon)))] = Trimmed(line.substr(colon + 1));
    }
  }

  template <int kRows, int kCols>
  Eigen::Matrix<double, kRows, kCols> Matrix(const std::string& key) const {
    Eigen::Matrix<double, kRows, kCols> matrix;
    std::istringstream words(Text(key));
    int count = 0;
    for (std::string word; words >> word; ++count) {
      const std::optional<double> number = ParseNumber<double>(word);
      if (!number || count == kRows * kCols) throw Bad(key, Numbers(kRows * kCols));
      matrix(count / kCols, count % kCols) = *number;
    }
    if (count < kRows * kCols) throw Bad(key, Numbers(kRows * kCols));
    return matrix;
  }

  bool Has(const std::string& key) const { return values_.contains(key); }

  ConfigError Bad(const std::string& key, const std::string& allowed) const {
    return ConfigError("calibration " + path_.string() + ": " + key + ": " + Text(key) +
                       ": allowed: " + allowed);
  }

 private:
  static std::string Numbers(int count) { return std::to_string(count) + " finite numbers"; }

  const std::string& Text(const std::string& key) const {
    const auto found = values_.find(key);
    if (found != values_.end()) return found->second;
    throw ConfigError("calibration " + path_.string() + ": " + key +
                      " is missing; allowed: a file with P2, P3, R0_rect and Tr_velo_to_cam");
  }

  std::filesystem::path path_;
  std::map<std::string, std::string> values_;
};

Eigen::Matrix3d Rotation(const KittiCalibFile& file, const std::string& key,
                         const Eigen::Matrix3d& matrix) {
  const double off = (matrix * matrix.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (off < kRotationTolerance && matrix.determinant() > 0) return matrix;
  throw file.Bad(key, "a rotation");
}

RectifiedPair PairOf(const KittiCalibFile& file, cv::Size size, const std::string& left_key,
                     const std::string& right_key) {
  const auto left = file.Matrix<3, 4>(left_key);
  const auto right = file.Matrix<3, 4>(right_key);
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

ProjectionKeys KeysOf(const KittiCalibFile& file, bool grey) {
  const std::string prefix = file.Has(grey ? "P_rect_00" : "P_rect_02") ? "P_rect_0" : "P";
  return {prefix + (grey ? "0" : "2"), prefix + (grey ? "1" : "3")};
}

RectifiedPair PairOf(const KittiCalibFile& file, cv::Size size, bool grey) {
  const ProjectionKeys keys = KeysOf(file, grey);
  return PairOf(file, size, keys.left, keys.right);
}

// P = K · [I | t].
Eigen::Vector3d LeftOffset(const KittiCalibFile& file, bool grey) {
  const auto left = file.Matrix<3, 4>(KeysOf(file, grey).left);
  const double z = left(2, 3);
  return {(left(0, 3) - left(0, 2) * z) / left(0, 0), (left(1, 3) - left(1, 2) * z) / left(0, 0),
          z};
}

}  // namespace

Eigen::Vector3d ReadKittiLeftOffset(const std::filesystem::path& path) {
  return LeftOffset(KittiCalibFile(path), /*grey=*/false);
}

RectifiedPair ReadKittiPair(const std::filesystem::path& path, cv::Size size, bool grey) {
  return PairOf(KittiCalibFile(path), size, grey);
}

KittiCalibration ReadKittiSequenceCalibration(const std::filesystem::path& path, cv::Size size,
                                              bool grey) {
  const KittiCalibFile file(path);
  KittiCalibration calibration{.pair = PairOf(file, size, grey)};
  if (!file.Has("Tr")) return calibration;
  const auto pose = file.Matrix<3, 4>("Tr");
  calibration.left_from_scanner.linear() = Rotation(file, "Tr", pose.leftCols<3>());
  calibration.left_from_scanner.translation() = pose.col(3) + LeftOffset(file, grey);
  return calibration;
}

KittiCalibration ReadKittiRawCalibration(const std::filesystem::path& folder, cv::Size size,
                                         bool grey) {
  const KittiCalibFile cameras(folder / "calib_cam_to_cam.txt");
  KittiCalibration calibration{.pair = PairOf(cameras, size, grey)};
  const KittiCalibFile scanner(folder / "calib_velo_to_cam.txt");
  const Eigen::Matrix3d rectification =
      Rotation(cameras, "R_rect_00", cameras.Matrix<3, 3>("R_rect_00"));
  calibration.left_from_scanner.linear() =
      rectification * Rotation(scanner, "R", scanner.Matrix<3, 3>("R"));
  calibration.left_from_scanner.translation() =
      rectification * scanner.Matrix<3, 1>("T") + LeftOffset(cameras, grey);
  return calibration;
}

KittiCalibration ReadKittiCalibration(const std::filesystem::path& path, cv::Size size) {
  const KittiCalibFile file(path);
  KittiCalibration calibration{.pair = PairOf(file, size, /*grey=*/false)};
  const Eigen::Matrix3d rectification = Rotation(file, "R0_rect", file.Matrix<3, 3>("R0_rect"));
  const auto pose = file.Matrix<3, 4>("Tr_velo_to_cam");
  calibration.left_from_scanner.linear() =
      rectification * Rotation(file, "Tr_velo_to_cam", pose.leftCols<3>());
  calibration.left_from_scanner.translation() =
      rectification * pose.col(3) + LeftOffset(file, /*grey=*/false);
  return calibration;
}

}  // namespace sprout::scenes
