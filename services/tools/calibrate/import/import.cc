#include "services/tools/calibrate/import/import.h"

#include <fmt/core.h>

#include <iostream>
#include <numbers>

#include "common/config/required.h"
#include "common/core/image.h"
#include "common/core/number_text.h"
#include "common/rig/rectifier.h"
#include "common/rig/rig_file.h"
#include "common/scenes/pfm.h"
#include "services/tools/calibrate/calibrator.h"
#include "services/tools/calibrate/import/foreign_rig.h"
#include "services/tools/calibrate/result_file.h"

namespace sprout::calibrate {
namespace {

// A longer baseline is in mm or in squares of a board, not in m, unless the user gives the unit.
constexpr double kMaxImportedBaselineM = 1;
// A shorter baseline is not possible, also not as one in mm or cm.
constexpr double kMinImportedBaselineM = 0.001;
constexpr char kUnits[] = "; allowed: --unit mm, cm, m, or metres (0.025: squares of 25 mm)";

cv::Size SizeOf(const std::string& text) {
  const auto size = ParseSize(text);
  if (!size || size->first < 1 || size->second < 1) {
    throw ConfigError("--size " + text + ": allowed is WIDTHxHEIGHT, px, such as 1280x720");
  }
  return {size->first, size->second};
}

double MetresPerUnit(const std::string& unit) {
  const auto metres = unit.empty() ? 1 : scenes::ParseRangeUnit(unit);
  if (!metres) throw ConfigError("--unit " + unit + kUnits);
  return *metres;
}

void FillSizes(const ImportOptions& options, ForeignRig& rig) {
  for (ForeignCamera* camera : {&rig.left, &rig.right}) {
    if (!options.size.empty()) {
      const cv::Size asked = SizeOf(options.size);
      if (!camera->size.empty() && camera->size != asked) {
        throw ConfigError("--size " + options.size + ": the file says " + SizeText(camera->size));
      }
      camera->size = asked;
    }
    if (camera->size.empty()) {
      throw ConfigError(camera->name +
                        ": the file does not say how large its images are; allowed: "
                        "--size WIDTHxHEIGHT");
    }
  }
}

Lens LensOf(const ForeignCamera& camera) {
  const LensFit fit = Required(ToLens(camera));
  const Lens& lens = fit.lens;
  std::cout << fmt::format("{}: {} px, f {:.2f}, {:.2f} px, principal point {:.2f}, {:.2f} px\n",
                           camera.name, SizeText(lens.size()), lens.fx, lens.fy, lens.cx, lens.cy);
  if (fit.worst_px > 0) {
    std::cout << fmt::format("  its distortion in Brown's terms; up to {:.3f} px off\n",
                             fit.worst_px);
  }
  return lens;
}

void ScaleToMetres(const ImportOptions& options, Pose& pose) {
  pose.translation_m *= MetresPerUnit(options.unit);
  const double baseline_m = pose.translation_m.norm();
  if ((options.unit.empty() && baseline_m > kMaxImportedBaselineM) ||
      baseline_m < kMinImportedBaselineM) {
    throw ConfigError(fmt::format("the cameras are {:g} m apart, if the unit of the file is {}{}",
                                  baseline_m, options.unit.empty() ? "m" : options.unit, kUnits));
  }
}

}  // namespace

int RunImport(const ImportOptions& options) {
  RequireResultFiles(options.files, options.rig, options.out, /*report=*/{});
  ForeignRig foreign = ReadForeignRig(options.files);
  if (options.fisheye) foreign.left.is_fisheye = foreign.right.is_fisheye = true;
  FillSizes(options, foreign);
  if (foreign.is_second_left) {
    std::cout << foreign.left.name << " stands on the left: its images are the left ones\n";
  }
  RigDescription description;
  if (!options.rig.empty()) description = LoadRigFile(options.rig);
  RawRig rig;
  rig.left = LensOf(foreign.left);
  rig.right = LensOf(foreign.right);
  rig.left_from_right = foreign.left_from_right;
  ScaleToMetres(options, rig.left_from_right);
  Required(CheckFoundRig(rig));
  const Eigen::Vector3d& place = rig.left_from_right.translation_m;
  const double degrees = 180 / std::numbers::pi *
                         Eigen::Quaterniond(rig.left_from_right.rotation)
                             .angularDistance(Eigen::Quaterniond::Identity());
  std::cout << fmt::format(
      "right camera in the left one's frame: {:.5f}, {:.5f}, {:.5f} m, turned by {:.3f} degrees\n",
      place.x(), place.y(), place.z(), degrees);
  if (const std::string warning = ViewsWarning(Rectifier(rig).views()); !warning.empty()) {
    std::cerr << "sprout-calibrate: " << warning << "\n";
  }
  *description.mutable_calibration() = ToCalibration(rig);
  description.clear_board_calibration();
  SaveResult(description, /*is_good=*/true, options.out);
  return 0;
}

}  // namespace sprout::calibrate
