#include "services/tools/calibrate/import/foreign_rig.h"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "common/config/required.h"
#include "common/core/printable.h"
#include "common/core/read_text.h"

namespace sprout::calibrate {
namespace {

ConfigError Bad(const ForeignFile& file, const std::string& what) {
  return ConfigError(file.path.string() + ": " + what);
}

// So many finite numbers of a list, or of a list of lists; 0: any number of them.
std::vector<double> Numbers(const ForeignFile& file, const YAML::Node& node,
                            const std::string& name, size_t count) {
  std::vector<double> numbers;
  bool is_list = node.IsDefined() && node.IsSequence();
  if (is_list) {
    for (const YAML::Node& one : node) {
      if (one.IsSequence()) {
        for (const YAML::Node& inner : one) numbers.push_back(inner.as<double>());
      } else {
        numbers.push_back(one.as<double>());
      }
    }
  }
  for (const double number : numbers) is_list = is_list && std::isfinite(number);
  if (!is_list || (count > 0 && numbers.size() != count)) {
    throw Bad(file, "no " + name + " of " + (count > 0 ? std::to_string(count) + " " : "") +
                        "finite numbers");
  }
  return numbers;
}

std::string Word(const YAML::Node& node) {
  return node.IsDefined() && node.IsScalar() ? node.as<std::string>() : "";
}

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

// The entries of the file and of its cameras: YAML allows a name once, and the library takes the
// first of several.
void RequireNamesOnce(const ForeignFile& file, const YAML::Node& map, bool is_file) {
  std::set<std::string> names;
  for (const auto& entry : map) {
    const std::string name = Word(entry.first);
    if (!names.insert(name).second) {
      throw Bad(file, Printable(name) + " is there twice; allowed: one of them");
    }
    if (is_file && entry.second.IsMap()) RequireNamesOnce(file, entry.second, /*is_file=*/false);
  }
}

// --- Kalibr ---

ForeignCamera KalibrCamera(const ForeignFile& file, const std::string& name,
                           const YAML::Node& node) {
  if (Word(node["camera_model"]) != "pinhole") {
    throw Bad(file,
              name + " has camera_model '" + Word(node["camera_model"]) + "'; allowed is pinhole");
  }
  const std::vector<double> k = Numbers(file, node["intrinsics"], name + ": intrinsics", 4);
  const std::vector<double> size = Numbers(file, node["resolution"], name + ": resolution", 2);
  ForeignCamera camera{.name = name,
                       .size = {static_cast<int>(size[0]), static_cast<int>(size[1])},
                       .distortion = {}};
  camera.k << k[0], 0, k[2], 0, k[1], k[3], 0, 0, 1;
  const std::string model = Word(node["distortion_model"]);
  if (model == "radtan" || model == "equidistant") {
    camera.distortion = Numbers(file, node["distortion_coeffs"], name + ": distortion_coeffs", 4);
    camera.is_fisheye = model == "equidistant";
  } else if (model != "none" && (!model.empty() || node["distortion_coeffs"].IsDefined())) {
    // Coefficients without a model are of radtan, or of equidistant.
    throw Bad(file, name + " has distortion_model '" + model +
                        "'; allowed are radtan, equidistant and none");
  }
  return camera;
}

ForeignRig KalibrRig(const ForeignFile& file, const YAML::Node& root) {
  if (!root["cam1"].IsDefined()) throw Bad(file, "no cam1; allowed is a camchain of two cameras");
  const std::vector<double> t = Numbers(file, root["cam1"]["T_cn_cnm1"], "cam1: T_cn_cnm1", 16);
  const RowMajor4 cam1_from_cam0 = Eigen::Map<const RowMajor4>(t.data());
  RequireRotation(file.path.string() + ": cam1: T_cn_cnm1", cam1_from_cam0.topLeftCorner<3, 3>());
  const Pose pose{
      .rotation =
          Eigen::Quaterniond(Eigen::Matrix3d(cam1_from_cam0.topLeftCorner<3, 3>())).normalized(),
      .translation_m = cam1_from_cam0.topRightCorner<3, 1>()};
  ForeignRig rig{.left = KalibrCamera(file, "cam0", root["cam0"]),
                 .right = KalibrCamera(file, "cam1", root["cam1"]),
                 .left_from_right = pose.Inverse()};
  if (rig.left_from_right.translation_m.x() < 0) {
    std::swap(rig.left, rig.right);
    rig.left_from_right = pose;
  }
  return rig;
}

// --- ROS ---

struct RosFile {
  ForeignCamera camera;
  ForeignRectification rectification;
};

std::vector<double> MatrixData(const ForeignFile& file, const YAML::Node& root, const char* name,
                               size_t count) {
  const YAML::Node node = root[name];
  if (!node.IsDefined() || !node.IsMap()) throw Bad(file, std::string("no ") + name);
  return Numbers(file, node["data"], std::string(name) + ": data", count);
}

RosFile ReadRosCamera(const ForeignFile& file, const YAML::Node& root) {
  RosFile ros;
  ForeignCamera& camera = ros.camera;
  camera.name = file.path.string();
  if (!root["image_width"].IsDefined() || !root["image_height"].IsDefined()) {
    throw Bad(file, "no image_width and image_height");
  }
  camera.size = {root["image_width"].as<int>(), root["image_height"].as<int>()};
  camera.k = Eigen::Map<const RowMajor3>(MatrixData(file, root, "camera_matrix", 9).data());
  camera.distortion = MatrixData(file, root, "distortion_coefficients", 0);
  const std::string model = Word(root["distortion_model"]);
  camera.is_fisheye = model == "equidistant" || model == "fisheye";
  if (!camera.is_fisheye && model != "plumb_bob" && model != "rational_polynomial") {
    throw Bad(file, "distortion_model '" + model +
                        "'; allowed are plumb_bob, rational_polynomial and equidistant");
  }
  const std::vector<double> p = MatrixData(file, root, "projection_matrix", 12);
  ros.rectification.rotation =
      Eigen::Map<const RowMajor3>(MatrixData(file, root, "rectification_matrix", 9).data());
  RequireRotation(file.path.string() + ": rectification_matrix", ros.rectification.rotation);
  ros.rectification.tx = p[3];
  ros.rectification.focal_px = p[0];
  if (p[0] <= 0) throw Bad(file, "projection_matrix has no focal length > 0");
  return ros;
}

ForeignRig RosRig(const std::vector<ForeignFile>& files, const std::vector<YAML::Node>& roots) {
  if (files.size() != 2) {
    throw Bad(files[0], "the camera_info of one camera; allowed are two files, left and right");
  }
  const RosFile left = ReadRosCamera(files[0], roots[0]);
  const RosFile right = ReadRosCamera(files[1], roots[1]);
  if (left.rectification.tx == right.rectification.tx) {
    throw Bad(files[1],
              "projection_matrix has the Tx of the left one, so there is no baseline: were the "
              "cameras calibrated as a pair?");
  }
  return {.left = left.camera,
          .right = right.camera,
          .left_from_right = PoseOfRectified(left.rectification, right.rectification)};
}

// The pair of a camchain of Kalibr (one file with cam0 and cam1), or of two camera_info files of
// ROS's camera_calibration, left and right.
// @throws ConfigError naming file and entry that cannot be used, or is missing.
ForeignRig ReadYamlRig(const std::vector<ForeignFile>& files) {
  std::vector<YAML::Node> roots;
  for (const ForeignFile& file : files) {
    if (file.text.find('\0') != std::string::npos) {
      throw Bad(file, "no text, but binary, as of NumPy or Matlab; allowed are YAML, XML and JSON");
    }
    try {
      roots.push_back(YAML::Load(file.text));
    } catch (const YAML::Exception& e) {
      throw Bad(file, std::string("no YAML: ") + e.what());
    }
    if (!roots.back().IsMap()) throw Bad(file, "no calibration of OpenCV, ROS or Kalibr");
    RequireNamesOnce(file, roots.back(), /*is_file=*/true);
  }
  try {
    if (roots[0]["cam0"].IsDefined()) {
      if (files.size() > 1) throw Bad(files[1], "a second file; allowed: a camchain alone");
      return KalibrRig(files[0], roots[0]);
    }
    if (roots[0]["camera_matrix"].IsDefined()) return RosRig(files, roots);
  } catch (const YAML::Exception& e) {
    throw Bad(files[0], std::string("an entry cannot be used: ") + e.what());
  }
  throw Bad(files[0],
            "no calibration of OpenCV (stereoCalibrate), ROS (camera_info) or Kalibr (camchain)");
}

}  // namespace

namespace fs = std::filesystem;

Pose PoseOfRectified(const ForeignRectification& left, const ForeignRectification& right) {
  const double baseline = (left.tx - right.tx) / left.focal_px;
  // x_right' = R' x' is R x less the baseline.
  const Eigen::Matrix3d back = left.rotation.transpose();
  return {.rotation = Eigen::Quaterniond(Eigen::Matrix3d(back * right.rotation)).normalized(),
          .translation_m = back * Eigen::Vector3d(baseline, 0, 0)};
}

void RequireRotation(const std::string& name, const Eigen::Matrix3d& matrix) {
  constexpr double kRounding = 1e-3;  // numbers may be written with few digits
  const bool is_rotation =
      (matrix * matrix.transpose()).isIdentity(kRounding) && matrix.determinant() > 0;
  if (!is_rotation) throw ConfigError(name + " is no rotation; allowed: a rotation matrix");
}

Result<LensFit> ToLens(const ForeignCamera& camera) {
  constexpr double kMostSkewPx = 1e-3;  // rounding
  if (const double skew_px = camera.k(0, 1); std::abs(skew_px) > kMostSkewPx) {
    return Fail(fmt::format("{}: its camera matrix has a skew of {:g} px; allowed: 0", camera.name,
                            skew_px));
  }
  if (!camera.k.row(2).isApprox(Eigen::RowVector3d(0, 0, 1))) {
    return Fail(camera.name +
                ": the last row of its camera matrix is not 0, 0, 1: is it "
                "transposed, as Matlab's IntrinsicMatrix?");
  }
  // With other counts OpenCV asserts. None: no distortion, which a fisheye lens always has.
  constexpr std::array<size_t, 6> kCounts = {0, 4, 5, 8, 12, 14};
  const size_t count = camera.distortion.size();
  const bool is_known =
      camera.is_fisheye ? count == 4 : std::ranges::find(kCounts, count) != kCounts.end();
  if (!is_known) {
    return Fail(fmt::format("{}: {} distortion coefficients; allowed: {}", camera.name, count,
                            camera.is_fisheye ? "4 of the fisheye model" : "4, 5, 8, 12 or 14"));
  }
  const LensFit fit = FitBrown({.width = camera.size.width,
                                .height = camera.size.height,
                                .fx = camera.k(0, 0),
                                .fy = camera.k(1, 1),
                                .cx = camera.k(0, 2),
                                .cy = camera.k(1, 2)},
                               camera.distortion, camera.is_fisheye);
  if (fit.worst_px > kWorstFitPx) {
    return Fail(fmt::format(
        "{}: its {} distortion is up to {:.2g} px from any of Brown's (k1, k2, p1, p2, k3), over "
        "the whole image; allowed are {:g}: calibrate it with sprout-calibrate estimate, or "
        "rectify the images with the program that has calibrated it",
        camera.name, camera.is_fisheye ? "fisheye" : "rational", fit.worst_px, kWorstFitPx));
  }
  return fit;
}

ForeignRig ReadForeignRig(const std::vector<fs::path>& files) {
  if (files.size() > 2) throw ConfigError("import: allowed are one file or two");
  std::vector<ForeignFile> texts;
  for (const fs::path& file : files) {
    texts.push_back({file, Required(ReadText(file), file.string() + ": ")});
  }
  if (std::ranges::all_of(texts, IsOpencvFile)) return ReadOpencvRig(texts);
  return ReadYamlRig(texts);
}

}  // namespace sprout::calibrate
