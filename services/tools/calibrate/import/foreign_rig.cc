#include "services/tools/calibrate/import/foreign_rig.h"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <set>
#include <string_view>
#include <utility>

#include "common/config/required.h"
#include "common/core/printable.h"
#include "common/core/read_text.h"

namespace sprout::calibrate {
namespace {

ConfigError Bad(const ForeignFile& file, const std::string& what) {
  return ConfigError(file.path.string() + ": " + what);
}

// The finite numbers of a list, or of a list of lists: `count` of them; 0: any number.
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

constexpr std::string_view kOpencvYamlLine = "%YAML:1.0";

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

// Refuses names that the file or one of its cameras has twice: yaml-cpp would take the first.
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

// The pose of a matrix of 4x4 numbers.
Pose PoseOf(const ForeignFile& file, const YAML::Node& node, const std::string& name) {
  const std::vector<double> numbers = Numbers(file, node, name, 16);
  const RowMajor4 matrix = Eigen::Map<const RowMajor4>(numbers.data());
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  RequireRotation(file.path.string() + ": " + name, rotation);
  return {.rotation = Eigen::Quaterniond(rotation).normalized(),
          .translation_m = matrix.topRightCorner<3, 1>()};
}

// --- Kalibr, and EuRoC, whose sensor.yaml describes a camera in nearly the same words ---

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
  const std::string coefficients = node["distortion_coefficients"].IsDefined()
                                       ? "distortion_coefficients"  // EuRoC's
                                       : "distortion_coeffs";
  if (model == "radtan" || model == "radial-tangential" || model == "equidistant") {
    camera.distortion = Numbers(file, node[coefficients], name + ": " + coefficients, 4);
    camera.is_fisheye = model == "equidistant";
  } else if (model != "none" && (!model.empty() || node[coefficients].IsDefined())) {
    // Coefficients without a model are of radtan, or of equidistant.
    throw Bad(file, name + " has distortion_model '" + model +
                        "'; allowed are radtan, equidistant and none");
  }
  return camera;
}

// Swaps the cameras where the second one stands on the left.
ForeignRig InOrder(ForeignRig rig) {
  if (rig.left_from_right.translation_m.x() >= 0) return rig;
  std::swap(rig.left, rig.right);
  rig.left_from_right = rig.left_from_right.Inverse();
  rig.is_second_left = true;
  return rig;
}

ForeignRig KalibrRig(const ForeignFile& file, const YAML::Node& root) {
  const YAML::Node& first = root["cam0"];
  const YAML::Node& second = root["cam1"];
  if (!second.IsDefined()) throw Bad(file, "no cam1; allowed is a camchain of two cameras");
  const auto pose = [&](const char* camera, const char* name) {
    return PoseOf(file, root[camera][name], std::string(camera) + ": " + name);
  };
  Pose cam0_from_cam1;
  if (second["T_cn_cnm1"].IsDefined() || !(first["T_cam_imu"] || first["T_imu_cam"])) {
    cam0_from_cam1 = pose("cam1", "T_cn_cnm1").Inverse();
  } else if (first["T_cam_imu"]) {
    cam0_from_cam1 = pose("cam0", "T_cam_imu") * pose("cam1", "T_cam_imu").Inverse();
  } else {  // OpenVINS'
    cam0_from_cam1 = pose("cam0", "T_imu_cam").Inverse() * pose("cam1", "T_imu_cam");
  }
  return InOrder({.left = KalibrCamera(file, "cam0", first),
                  .right = KalibrCamera(file, "cam1", second),
                  .left_from_right = cam0_from_cam1});
}

// T_BS takes points of the camera to the body.
ForeignRig EurocRig(const std::vector<ForeignFile>& files, const std::vector<YAML::Node>& roots) {
  if (files.size() != 2) {
    throw Bad(files[0], "EuRoC's sensor.yaml of one camera; allowed are two, of cam0 and cam1");
  }
  const Pose first = PoseOf(files[0], roots[0]["T_BS"]["data"], "T_BS: data");
  const Pose second = PoseOf(files[1], roots[1]["T_BS"]["data"], "T_BS: data");
  return InOrder({.left = KalibrCamera(files[0], files[0].path.string(), roots[0]),
                  .right = KalibrCamera(files[1], files[1].path.string(), roots[1]),
                  .left_from_right = first.Inverse() * second});
}

// --- Programs whose calibrations are not read ---

constexpr char kCure[] =
    "; allowed are OpenCV's (stereoCalibrate), ROS's (camera_info), Kalibr's (camchain) and "
    "EuRoC's, or a rig file with its numbers (README of sprout-calibrate, A rig file)";
constexpr char kRectified[] =
    "; the images of its SDK are rectified, so sprout-pipeline files --focal-px, --baseline-m "
    "needs no rig "
    "file";
constexpr char kCalib[] = "; sprout-pipeline files --calib reads it";

struct OtherProgram {
  std::string_view mark;  // is in its files
  std::string_view name;
  const char* cure;
};
constexpr OtherProgram kOthers[] = {
    {"[LEFT_CAM_", "a .conf of ZED", kRectified},
    {"stream-depth-format", "the settings of a RealSense, no calibration", kRectified},
    {"\"ppx\"", "the intrinsics of one camera of a RealSense", kRectified},
    {"\"cameraData\"", "a calibration of DepthAI (OAK)", kCure},
    {"\"T_imu_cam\"", "a calibration of Basalt", kCure},
    {"\"intrinsic_matrix\"", "the intrinsics of one camera, of Open3D", kCure},
    {"\"CameraParameters1\"", "a stereoParameters of Matlab", kCure},
    {"Camera1.fx", "the settings of ORB-SLAM3", kCure},
    {"cam0_calib:", "the settings of VINS, whose cameras have files of their own", kCure},
    {"projection_parameters:", "a camera of VINS or camodocal", kCure},
    {"fc_left", "a calibration of Bouguet's toolbox", kCure},
    {"CAMERA_ID, MODEL", "COLMAP's cameras, which do not say how a pair stands", kCure},
    {"ustar", "an archive; unpack it with tar -xf", ""},
    {"oST version", "ROS's ost.txt; left.yaml and right.yaml of the same archive are read", ""},
    {"Camera-system parameters:", "a report of Kalibr; its camchain is read", ""},
    {"cam0=[", "a calib.txt of Middlebury", kCalib},
    {"P0: ", "a calib.txt of KITTI", kCalib},
    {"P_rect_", "a calib_cam_to_cam.txt of KITTI", kCalib},
};

// @throws ConfigError naming the program whose file it is, if it is known, and what to do.
void RefuseOtherPrograms(const ForeignFile& file) {
  for (const OtherProgram& other : kOthers) {
    if (file.text.find(other.mark) == std::string::npos) continue;
    throw Bad(file, std::string(other.name) + other.cure);
  }
}

// --- ROS ---

struct RosFile {
  ForeignCamera camera;
  ForeignRectification rectification;
  double row_px = 0;  // c_y of the rectified image
};

// @param field  of the message, as `ros2 topic echo` and `rostopic echo` (in capitals) print it.
std::vector<double> MatrixData(const ForeignFile& file, const YAML::Node& root, const char* name,
                               char field, size_t count) {
  const YAML::Node node = root[name];
  if (node.IsDefined() && node.IsMap()) {
    return Numbers(file, node["data"], std::string(name) + ": data", count);
  }
  for (const char letter : {field, static_cast<char>(std::toupper(field))}) {
    const std::string echoed(1, letter);
    if (root[echoed]) return Numbers(file, root[echoed], echoed, count);
  }
  throw Bad(file, std::string("no ") + name);
}

RosFile ReadRosCamera(const ForeignFile& file, const YAML::Node& root) {
  RosFile ros;
  ForeignCamera& camera = ros.camera;
  camera.name = file.path.string();
  const YAML::Node& width = root["image_width"] ? root["image_width"] : root["width"];
  const YAML::Node& height = root["image_height"] ? root["image_height"] : root["height"];
  if (!width || !height) throw Bad(file, "no image_width and image_height");
  camera.size = {width.as<int>(), height.as<int>()};
  camera.k = Eigen::Map<const RowMajor3>(MatrixData(file, root, "camera_matrix", 'k', 9).data());
  camera.distortion = MatrixData(file, root, "distortion_coefficients", 'd', 0);
  const std::string model = Word(root["distortion_model"]);
  camera.is_fisheye = model == "equidistant" || model == "fisheye";
  if (!camera.is_fisheye && model != "plumb_bob" && model != "rational_polynomial") {
    throw Bad(file, "distortion_model '" + model +
                        "'; allowed are plumb_bob, rational_polynomial and equidistant");
  }
  const std::vector<double> p = MatrixData(file, root, "projection_matrix", 'p', 12);
  ros.rectification.rotation =
      Eigen::Map<const RowMajor3>(MatrixData(file, root, "rectification_matrix", 'r', 9).data());
  RequireRotation(file.path.string() + ": rectification_matrix", ros.rectification.rotation);
  ros.rectification.tx = p[3];
  ros.rectification.focal_px = p[0];
  ros.row_px = p[6];
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
  constexpr double kRounding = 1e-3;  // of files with few digits
  const double focal_px = left.rectification.focal_px;
  if (std::max(std::abs(right.rectification.focal_px - focal_px),
               std::abs(right.row_px - left.row_px)) > kRounding * focal_px) {
    throw Bad(files[1],
              fmt::format("projection_matrix has f = {:g} and cy = {:g} px, that of the "
                          "left one {:g} and {:g}: are both files of one calibration?",
                          right.rectification.focal_px, right.row_px, focal_px, left.row_px));
  }
  return {.left = left.camera,
          .right = right.camera,
          .left_from_right = PoseOfRectified(left.rectification, right.rectification)};
}

// Rewrites files in flow style: PyYAML's matrices are lists in block style, which OpenCV cannot
// read.
std::vector<ForeignFile> InFlowStyle(std::vector<ForeignFile> files,
                                     const std::vector<YAML::Node>& roots) {
  for (size_t i = 0; i < files.size(); ++i) {
    if (IsOpencvFile(files[i])) continue;
    for (const auto& entry : roots[i]) {
      YAML::Node value = entry.second;
      if (value.IsSequence()) value.SetStyle(YAML::EmitterStyle::Flow);
    }
    files[i].text = std::string(kOpencvYamlLine) + "\n---\n" + YAML::Dump(roots[i]) + "\n";
  }
  return files;
}

// The pair of a camchain of Kalibr (one file with cam0 and cam1), of two files of ROS's
// camera_calibration or EuRoC, left and right, or of matrices in lists.
// @throws ConfigError naming file and entry that cannot be used, or is missing.
ForeignRig ReadYamlRig(const std::vector<ForeignFile>& files) {
  std::vector<YAML::Node> roots;
  for (const ForeignFile& file : files) {
    if (file.text.find('\0') != std::string::npos) {
      throw Bad(file, "no text, but binary, as of NumPy or Matlab; allowed are YAML, XML and JSON");
    }
    try {
      // OpenCV's first line, which yaml-cpp refuses, and which other programs copy.
      const bool is_copied = file.text.starts_with(kOpencvYamlLine);
      roots.push_back(YAML::Load(is_copied ? file.text.substr(kOpencvYamlLine.size()) : file.text));
    } catch (const YAML::Exception& e) {
      throw Bad(file, std::string("no YAML: ") + e.what() + kCure);
    }
    if (!roots.back().IsMap()) throw Bad(file, std::string("no calibration that is known") + kCure);
    RequireNamesOnce(file, roots.back(), /*is_file=*/true);
  }
  try {
    if (roots[0]["cam0"].IsDefined()) {
      if (files.size() > 1) throw Bad(files[1], "a second file; allowed: a camchain alone");
      return KalibrRig(files[0], roots[0]);
    }
    if (roots[0]["T_BS"]) return EurocRig(files, roots);
    if (roots[0]["camera_matrix"] || roots[0]["distortion_model"]) return RosRig(files, roots);
  } catch (const YAML::Exception& e) {
    throw Bad(files[0], std::string("an entry cannot be used: ") + e.what());
  }
  const bool has_lists = std::ranges::any_of(roots, [](const YAML::Node& root) {
    return std::ranges::any_of(root, [](const auto& entry) { return entry.second.IsSequence(); });
  });
  if (has_lists) return ReadOpencvRig(InFlowStyle(files, roots));
  throw Bad(files[0], std::string("no calibration that is known") + kCure);
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
  constexpr double kMaxSkewPx = 1e-3;  // rounding
  if (const double skew_px = camera.k(0, 1); std::abs(skew_px) > kMaxSkewPx) {
    return Fail(fmt::format("{}: its camera matrix has a skew of {:g} px; allowed: 0", camera.name,
                            skew_px));
  }
  if (!camera.k.row(2).isApprox(Eigen::RowVector3d(0, 0, 1))) {
    return Fail(camera.name +
                ": the last row of its camera matrix is not 0, 0, 1: is it "
                "transposed, as Matlab's IntrinsicMatrix?");
  }
  // OpenCV fails an assertion for other counts. 0 is no distortion, but a fisheye lens always has
  // one.
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
    RefuseOtherPrograms(texts.back());
  }
  if (std::ranges::all_of(texts, IsOpencvFile)) return ReadOpencvRig(texts);
  return ReadYamlRig(texts);
}

}  // namespace sprout::calibrate
