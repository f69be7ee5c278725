#include "common/rig/rig_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "common/config/config.h"
#include "common/config/required.h"
#include "common/core/number_text.h"
#include "common/core/output_file.h"
#include "common/core/printable.h"
#include "common/core/read_text.h"
#include "common/rig/rectification.h"

namespace sprout {
namespace {

namespace fs = std::filesystem;
using Numbers = google::protobuf::RepeatedField<double>;

// The numbers of a repeated field; none at all leave `values` alone.
template <typename Values>
void Fill(const std::string& field, const Numbers& numbers, bool may_be_fewer, Values& values) {
  const int allowed = static_cast<int>(values.size());
  if (numbers.empty()) return;
  if (numbers.size() > allowed || (numbers.size() < allowed && !may_be_fewer)) {
    throw ConfigError(field + ": " + std::to_string(numbers.size()) +
                      " numbers; allowed: " + std::to_string(allowed));
  }
  std::copy(numbers.begin(), numbers.end(), values.begin());
}

// A principal point that is not there is no corner of the image: as NaN it is refused by its name.
Lens LensOf(const std::string& name, const LensModel& model) {
  constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
  Lens lens{.width = model.width(),
            .height = model.height(),
            .fx = model.fx(),
            .fy = model.fy(),
            .cx = model.has_cx() ? model.cx() : kMissing,
            .cy = model.has_cy() ? model.cy() : kMissing};
  Fill(name + ".distortion", model.distortion(), /*may_be_fewer=*/true, lens.distortion);
  return lens;
}

Pose PoseOf(const std::string& name, const RigPose& message) {
  std::array<double, 4> q{1, 0, 0, 0};
  std::array<double, 3> t{};
  Fill(name + ".rotation", message.rotation(), /*may_be_fewer=*/false, q);
  Fill(name + ".translation_m", message.translation_m(), /*may_be_fewer=*/false, t);
  Pose pose{.rotation = {q[0], q[1], q[2], q[3]}, .translation_m = {t[0], t[1], t[2]}};
  // People write three or four digits; what programs write stays as it is.
  constexpr double kRounded = 1e-3;
  constexpr double kExact = 1e-6;
  const double off = std::abs(pose.rotation.norm() - 1);
  if (off > kExact && off < kRounded) pose.rotation.normalize();
  return pose;
}

// Whether a text looks like a calibration of another program: XML, JSON, an .ini, an archive, or
// with names as OpenCV, ROS, Kalibr, EuRoC, COLMAP, Middlebury or KITTI have.
bool IsOfOthers(std::string_view text) {
  constexpr std::string_view kBegins[] = {"%YAML", "<?xml", "{", "[", "PK"};
  constexpr std::string_view kNames[] = {"!!opencv-matrix", "camera_matrix:", "cam0:", "T_BS:",
                                         "CAMERA_ID,",      "cam0=[",         "P0: ",  "P_rect_"};
  return std::ranges::any_of(kBegins, [&](auto begin) { return text.starts_with(begin); }) ||
         std::ranges::any_of(kNames, [&](auto name) { return text.find(name) != text.npos; });
}

void RequireOk(const Checks& checks) {
  if (!checks.ok()) throw ConfigError(checks.error().value().text);
}

Lens CheckedLens(const std::string& name, const LensModel& model) {
  const Lens lens = LensOf(name, model);
  Checks checks;
  CheckCamera(checks, name, lens);
  RequireOk(checks);
  return lens;
}

Pose CheckedPose(const std::string& name, const RigPose& message) {
  const Pose pose = PoseOf(name, message);
  Checks checks;
  CheckPose(checks, name, pose);
  RequireOk(checks);
  return pose;
}

// @param field  of the calibration, with a dot behind it.
RawRig CheckedRig(const std::string& field, const RigCalibration& calibration) {
  RawRig rig;
  rig.left = LensOf(field + "left", calibration.left());
  rig.right = LensOf(field + "right", calibration.right());
  rig.left_from_right = PoseOf(field + "left_from_right", calibration.left_from_right());
  if (calibration.has_tof()) rig.tof = LensOf(field + "tof", calibration.tof());
  rig.left_from_tof = PoseOf(field + "left_from_tof", calibration.left_from_tof());
  rig.range_scale = calibration.range_scale();
  rig.range_offset_m = calibration.range_offset_m();
  for (const RangeCorrectionKnot& knot : calibration.range_correction()) {
    rig.range_correction.push_back({knot.range_m(), knot.offset_m(), knot.sigma_m()});
  }
  const auto& light = calibration.amplitude_correction();
  rig.amplitude_correction = {light.offset_m(), light.sigma_m(), light.middle()};
  Required(CheckRawRig(rig), field);
  return rig;
}

void Set(const Lens& lens, LensModel& model) {
  model.set_width(lens.width);
  model.set_height(lens.height);
  model.set_fx(lens.fx);
  model.set_fy(lens.fy);
  model.set_cx(lens.cx);
  model.set_cy(lens.cy);
  for (double value : lens.distortion) model.add_distortion(value);
}

void Set(const Pose& pose, RigPose& message) {
  const auto& q = pose.rotation;
  for (double value : {q.w(), q.x(), q.y(), q.z()}) message.add_rotation(value);
  for (double value : pose.translation_m) message.add_translation_m(value);
}

// Where a comment begins in a line of the text format.
size_t CommentIn(std::string_view line) {
  char quote = 0;
  for (size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote != 0) {
      if (c == '\\') ++i;
      if (c == quote) quote = 0;
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (c == '#') {
      return i;
    }
  }
  return std::string_view::npos;
}

// The lines with comments, as comments.
std::string CommentsOf(const std::string& text) {
  std::string comments;
  for (const std::string_view line : SplitAt('\n', text)) {
    if (CommentIn(line) == std::string_view::npos) continue;
    const std::string_view trimmed = Trimmed(line);
    comments += (trimmed.front() == '#' ? "" : "# ") + Printable(trimmed) + "\n";
  }
  return comments;
}

}  // namespace

RigDescription LoadRigFile(const fs::path& path) {
  RigDescription rig;
  if (const Result<std::string> text = ReadText(path); text && IsOfOthers(*text)) {
    throw ConfigError("rig file " + path.string() +
                      ": the calibration of another program; sprout-calibrate import makes a rig "
                      "file of it, or says what to do");
  }
  ParseTextFile(path, "rig file", "a file as sprout-calibrate writes it", rig);
  RequireInRange(rig, "rig file " + path.string() + ": rig");
  return rig;
}

Result<void> SaveRigFile(const fs::path& path, const RigDescription& rig) {
  OutputFile file(path, OutputFile::OverInput::kAllowed);
  if (const Result<std::string> before = ReadText(path)) file.Write(CommentsOf(*before));
  file.Write(ConfigText(rig));
  return file.Commit();
}

std::optional<RawRig> CalibrationOf(const RigDescription& description) {
  if (!description.has_calibration()) return std::nullopt;
  return CheckedRig("calibration.", description.calibration());
}

TofCamera TofCameraOf(const RigDescription& description, const fs::path& path) {
  const RigCalibration& calibration = description.calibration();
  if (!calibration.has_tof()) {
    throw ConfigError("rig file " + path.string() +
                      ": no ToF camera; allowed: a file with calibration { tof left_from_tof }");
  }
  if (calibration.range_scale() != 1 || calibration.range_offset_m() != 0 ||
      calibration.range_correction_size() > 0 || calibration.has_amplitude_correction()) {
    throw ConfigError("rig file " + path.string() +
                      ": a bias of the range, but no left and right cameras; allowed: range_scale: "
                      "1, range_offset_m: 0, no range_correction, no amplitude_correction");
  }
  const Lens lens = CheckedLens("calibration.tof", calibration.tof());
  return TofCameraOf(lens, CheckedPose("calibration.left_from_tof", calibration.left_from_tof()));
}

std::optional<RawRig> BoardCalibrationOf(const RigDescription& description) {
  if (!description.has_board_calibration()) return CalibrationOf(description);
  return CheckedRig("board_calibration.", description.board_calibration());
}

RawRig RequireCalibration(const RigDescription& rig, const fs::path& path) {
  const std::string file = "rig file " + path.string() + ": ";
  try {
    if (const std::optional<RawRig> calibration = CalibrationOf(rig)) return *calibration;
  } catch (const ConfigError& e) {
    throw ConfigError(file + e.what());
  }
  throw ConfigError(file + "no calibration in it; sprout-calibrate writes one");
}

RigPlaces PlacesOf(const RigDescription& description, const fs::path& path) {
  const std::string file = "rig file " + path.string() + ": ";
  RigPlaces places;
  Pose rectified_from_left;
  try {
    if (const std::optional<RawRig> rig = CalibrationOf(description)) {
      const Rectification made = RectificationOf(*rig);
      places.pair = made.pair;
      rectified_from_left.rotation =
          Eigen::Quaterniond(Eigen::Matrix3d(BackOf(made.left_turn).transpose())).normalized();
    }
    if (description.has_base_from_left()) {
      const Pose base = CheckedPose("base_from_left", description.base_from_left());
      places.base_from_left = base * rectified_from_left.Inverse();
    }
    for (const OtherCamera& other : description.others()) {
      const std::string name = "others { name: \"" + other.name() + "\" }";
      const OtherCameraPlace place{CheckedLens(name + ".lens", other.lens()),
                                   rectified_from_left * CheckedPose(name + ".pose", other.pose())};
      if (other.name().empty() || !places.others.emplace(other.name(), place).second) {
        throw ConfigError(name + ": allowed: names that are not empty, each once");
      }
    }
  } catch (const ConfigError& e) {
    throw ConfigError(file + e.what());
  }
  return places;
}

RigCalibration ToCalibration(const RawRig& rig) {
  RigCalibration calibration;
  Set(rig.left, *calibration.mutable_left());
  Set(rig.right, *calibration.mutable_right());
  Set(rig.left_from_right, *calibration.mutable_left_from_right());
  if (rig.tof.width > 0) {
    Set(rig.tof, *calibration.mutable_tof());
    Set(rig.left_from_tof, *calibration.mutable_left_from_tof());
  }
  calibration.set_range_scale(rig.range_scale);
  calibration.set_range_offset_m(rig.range_offset_m);
  for (const CorrectionKnot& knot : rig.range_correction) {
    RangeCorrectionKnot& message = *calibration.add_range_correction();
    message.set_range_m(knot.range_m);
    message.set_offset_m(knot.offset_m);
    message.set_sigma_m(knot.sigma_m);
  }
  if (const AmplitudeCorrection& light = rig.amplitude_correction; !light.empty()) {
    auto& message = *calibration.mutable_amplitude_correction();
    message.set_offset_m(light.offset_m);
    message.set_sigma_m(light.sigma_m);
    message.set_middle(light.middle);
  }
  return calibration;
}

}  // namespace sprout
