#include "services/tools/calibrate/import/foreign_rig.h"

#include <fmt/core.h>

#include <algorithm>

#include "common/config/config_error.h"
#include "common/core/read_text.h"
#include "services/tools/calibrate/import/opencv_file.h"
#include "services/tools/calibrate/import/yaml_file.h"

namespace sprout::calibrate {

namespace fs = std::filesystem;

Pose PoseOfRectified(const ForeignRectification& left, const ForeignRectification& right) {
  const double baseline = (left.tx - right.tx) / left.focal_px;
  // x_right' = R' x' is R x less the baseline.
  const Eigen::Matrix3d back = left.rotation.transpose();
  return {.rotation = Eigen::Quaterniond(Eigen::Matrix3d(back * right.rotation)).normalized(),
          .translation_m = back * Eigen::Vector3d(baseline, 0, 0)};
}

Result<LensFit> ToLens(const ForeignCamera& camera) {
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
    const Result<std::string> text = ReadText(file);
    if (!text) throw ConfigError(file.string() + ": " + text.error().text);
    texts.push_back({file, *text});
  }
  if (std::ranges::all_of(texts, IsOpencvFile)) return ReadOpencvRig(texts);
  return ReadYamlRig(texts);
}

}  // namespace sprout::calibrate
