#include "services/calibrate/import/foreign_rig.h"

#include <fmt/core.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "common/config/config_error.h"
#include "common/core/read_text.h"
#include "common/geometry/lens.h"
#include "services/calibrate/import/opencv_file.h"
#include "services/calibrate/import/yaml_file.h"

namespace sprout::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr size_t kBrown = 5;

bool IsBrown(const ForeignCamera& camera) {
  const auto more = camera.distortion.begin() +
                    std::min(std::ssize(camera.distortion), static_cast<std::ptrdiff_t>(kBrown));
  return !camera.is_fisheye &&
         std::all_of(more, camera.distortion.end(), [](double value) { return value == 0; });
}

// Directions (x, y, 1) of pixels, by the model that the file has.
std::vector<cv::Point2d> DirectionsOf(const ForeignCamera& camera,
                                      const std::vector<cv::Point2d>& pixels) {
  const cv::Matx33d k(camera.k(0, 0), 0, camera.k(0, 2), 0, camera.k(1, 1), camera.k(1, 2), 0, 0,
                      1);
  std::vector<cv::Point2d> directions;
  if (camera.is_fisheye) {
    cv::fisheye::undistortPoints(pixels, directions, k, camera.distortion);
  } else {
    const cv::TermCriteria exact(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 200, 1e-12);
    cv::undistortPoints(pixels, directions, k, camera.distortion, cv::noArray(), cv::noArray(),
                        exact);
  }
  return directions;
}

// With x, y and r² of a direction, Brown's place is
//   x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²), and y in the same way:
// linear in its coefficients.
void FitDistortion(const std::vector<cv::Point2d>& directions,
                   const std::vector<cv::Point2d>& pixels, Lens& lens) {
  Eigen::MatrixXd a(2 * std::ssize(directions), static_cast<Eigen::Index>(kBrown));
  Eigen::VectorXd b(a.rows());
  for (size_t i = 0; i < directions.size(); ++i) {
    const auto [x, y] = directions[i];
    const double r2 = x * x + y * y;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    a.row(row) << x * r2, x * r2 * r2, 2 * x * y, r2 + 2 * x * x, x * r2 * r2 * r2;
    a.row(row + 1) << y * r2, y * r2 * r2, r2 + 2 * y * y, 2 * x * y, y * r2 * r2 * r2;
    b(row) = (pixels[i].x - lens.cx) / lens.fx - x;
    b(row + 1) = (pixels[i].y - lens.cy) / lens.fy - y;
  }
  const Eigen::VectorXd best = a.colPivHouseholderQr().solve(b);
  std::ranges::copy(best, lens.distortion.begin());
}

}  // namespace

Pose PoseOfRectified(const ForeignRectification& left, const ForeignRectification& right) {
  const double baseline = (left.tx - right.tx) / left.focal_px;
  // x_right' = R' x' is R x less the baseline.
  const Eigen::Matrix3d back = left.rotation.transpose();
  return {.rotation = Eigen::Quaterniond(Eigen::Matrix3d(back * right.rotation)).normalized(),
          .translation_m = back * Eigen::Vector3d(baseline, 0, 0)};
}

Result<LensFit> ToLens(const ForeignCamera& camera) {
  LensFit fit;
  fit.lens = {.width = camera.size.width,
              .height = camera.size.height,
              .fx = camera.k(0, 0),
              .fy = camera.k(1, 1),
              .cx = camera.k(0, 2),
              .cy = camera.k(1, 2)};
  if (IsBrown(camera)) {
    std::copy_n(camera.distortion.begin(), std::min(camera.distortion.size(), kBrown),
                fit.lens.distortion.begin());
    return fit;
  }
  constexpr int kSteps = 24;
  std::vector<cv::Point2d> pixels;
  for (int row = 0; row <= kSteps; ++row) {
    for (int column = 0; column <= kSteps; ++column) {
      pixels.emplace_back((camera.size.width - 1.0) * column / kSteps,
                          (camera.size.height - 1.0) * row / kSteps);
    }
  }
  const std::vector<cv::Point2d> directions = DirectionsOf(camera, pixels);
  FitDistortion(directions, pixels, fit.lens);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Vector2d again = PixelOfDirection(fit.lens, {directions[i].x, directions[i].y});
    const double off_px = (again - Eigen::Vector2d(pixels[i].x, pixels[i].y)).norm();
    fit.worst_px = std::isfinite(off_px) ? std::max(fit.worst_px, off_px) : INFINITY;
  }
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
