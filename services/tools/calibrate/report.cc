#include "services/tools/calibrate/report.h"

#include <fmt/core.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "common/picture/html.h"
#include "common/rig/rectifier.h"
#include "services/tools/calibrate/report_page.h"
#include "services/tools/calibrate/report_pictures.h"

namespace sprout::calibrate {
namespace {

constexpr std::array<const char*, kLensNumbers> kLensNames = {
    "fx (px)", "fy (px)", "cx (px)", "cy (px)", "k1", "k2", "p1", "p2", "k3"};

std::array<double, kLensNumbers> NumbersOf(const Lens& lens) {
  const auto& k = lens.distortion;
  return {lens.fx, lens.fy, lens.cx, lens.cy, k[0], k[1], k[2], k[3], k[4]};
}

bool HasTof(const Calibration& calibration) { return calibration.rig.tof.width > 0; }

struct Row {
  std::string name;
  std::string value;
};

// What is to be known about the whole rig.
std::vector<Row> RigRows(const Calibration& calibration) {
  const CalibrationQuality& quality = calibration.quality;
  const RawRig& rig = calibration.rig;
  std::vector<Row> rows;
  for (const CameraIndex camera : {kLeft, kRight, kTof}) {
    if (camera == kTof && !HasTof(calibration)) continue;
    const CameraQuality& of_camera = quality.cameras[camera];
    rows.push_back(
        {fmt::format("{}: reprojection error", kCameraNames[camera]),
         fmt::format("{:.3f} px rms, {} corners in {} views, {} outliers", of_camera.rms_px,
                     of_camera.residuals.size(), of_camera.views, of_camera.outliers)});
  }
  rows.push_back(
      {"baseline", fmt::format("{:.2f} mm", 1000 * rig.left_from_right.translation_m.norm())});
  rows.push_back({"rows of the rectified pair",
                  fmt::format("{:.3f} px apart in the median, 95 % below {:.3f} px",
                              quality.epipolar_median_px, quality.epipolar_95_px)});
  rows.push_back({"rectified images",
                  fmt::format("show {:.0f} % of what a camera sees", 100 * quality.views.kept)});
  if (!HasTof(calibration)) return rows;
  rows.push_back(
      {"ToF points in the left image", fmt::format("± {:.2f} px", quality.tof_landing_px)});
  rows.push_back(
      {"ToF ranges",
       fmt::format("{:.5f} · measured {:+.1f} mm, ± {:.1f} mm from {:.2f} to {:.2f} m",
                   rig.range_scale, 1000 * rig.range_offset_m, 1000 * quality.range_sigma_m,
                   quality.nearest_m, quality.farthest_m)});
  rows.push_back(
      {"ToF ranges against the board",
       fmt::format("{:.1f} mm rms, {} squares", 1000 * quality.range_rms_m, quality.ranges)});
  return rows;
}

std::string LensTable(const Calibration& calibration) {
  const RawRig& rig = calibration.rig;
  std::vector<std::vector<std::string>> rows = {{"", "left", "right"}};
  if (HasTof(calibration)) rows[0].emplace_back("ToF");
  for (size_t i = 0; i < kLensNumbers; ++i) {
    rows.push_back({kLensNames[i]});
    for (const CameraIndex camera : {kLeft, kRight, kTof}) {
      if (camera == kTof && !HasTof(calibration)) continue;
      const Lens& lens = camera == kLeft ? rig.left : camera == kRight ? rig.right : rig.tof;
      rows.back().push_back(fmt::format("{:.{}f} ± {:.{}f}", NumbersOf(lens)[i], i < 4 ? 2 : 5,
                                        calibration.quality.cameras[camera].deviation.lens[i],
                                        i < 4 ? 2 : 5));
    }
  }
  return TableHtml(rows);
}

std::string PoseTable(const Calibration& calibration) {
  const RawRig& rig = calibration.rig;
  std::vector<std::vector<std::string>> rows = {{"in the left camera's frame", "x (mm)", "y (mm)",
                                                 "z (mm)", "turn x (°)", "turn y (°)",
                                                 "turn z (°)"}};
  const auto add = [&](const char* name, const Pose& pose, CameraIndex camera) {
    const Eigen::AngleAxisd turn(pose.rotation);
    const auto& deviation = calibration.quality.cameras[camera].deviation.pose;
    rows.push_back({name});
    for (size_t i = 0; i < 3; ++i) {
      rows.back().push_back(fmt::format("{:.2f} ± {:.2f}",
                                        1000 * pose.translation_m[static_cast<Eigen::Index>(i)],
                                        1000 * deviation[3 + i]));
    }
    constexpr double kDegrees = 180 / std::numbers::pi;
    for (size_t i = 0; i < 3; ++i) {
      const double angle = turn.angle() * turn.axis()[static_cast<Eigen::Index>(i)];
      rows.back().push_back(
          fmt::format("{:.3f} ± {:.3f}", kDegrees * angle, kDegrees * deviation[i]));
    }
  };
  add("right", rig.left_from_right, kRight);
  if (HasTof(calibration)) add("ToF", rig.left_from_tof, kTof);
  return TableHtml(rows);
}

}  // namespace

std::string CountsText(const ViewCounts& counts, size_t views) {
  std::string text = fmt::format("{} images: {} views used", counts.images, views);
  const auto add = [&](int count, const char* what) {
    if (count > 0) text += fmt::format(", {} {}", count, what);
  };
  add(counts.similar, "like another one");
  add(counts.moving, "with a moving board");
  add(counts.no_board, "without the board");
  add(counts.other_size, "of another size");
  add(counts.too_many, "beyond what is needed");
  return text;
}

std::string SummaryText(const Calibration& calibration) {
  std::string text = "calibration: " + VerdictText(calibration.quality.is_good()) + "\n";
  for (const std::string& reason : calibration.quality.reasons) text += "  * " + reason + "\n";
  for (const Row& row : RigRows(calibration)) {
    text += fmt::format("{:<30} {}\n", row.name, row.value);
  }
  return text;
}

std::string ReportHtml(const Calibration& calibration, const RigImages& images,
                       const std::string& counts_text) {
  const CalibrationQuality& quality = calibration.quality;
  const RawRig& rig = calibration.rig;
  const Rectifier rectifier(rig);
  const cv::Mat left = rectifier.RectifyLeft(images.left);
  std::string html = ReportStart("Calibration", quality.reasons);
  html += "<p>" + EscapedHtml(counts_text) + ".</p>\n";
  std::vector<std::vector<std::string>> rows = {{"what", "how good"}};
  for (const Row& row : RigRows(calibration)) rows.push_back({row.name, row.value});
  html += TableHtml(rows);
  html +=
      "<h2>Lenses</h2>\n<p>± is a standard deviation, from the scatter and the number of the "
      "corners.</p>\n" +
      LensTable(calibration) + "<h2>Poses</h2>\n" + PoseTable(calibration);
  html +=
      "<h2>Where the corners were</h2>\n<p>A dot each, from blue (no error) to red (4 standard "
      "deviations). No part of an image should be empty.</p>\n";
  html += FigureHtml(CoveragePicture(quality.cameras[kLeft], rig.left.size()), "left");
  html += FigureHtml(CoveragePicture(quality.cameras[kRight], rig.right.size()), "right");
  if (HasTof(calibration)) {
    html += FigureHtml(CoveragePicture(quality.cameras[kTof], rig.tof.size()), "ToF");
  }
  html += "<h2>The rectified pair</h2>\n" +
          FigureHtml(PairPicture(left, rectifier.RectifyRight(images.right)),
                     "A point lies on the same row in both images.");
  if (HasTof(calibration) && !images.tof.depth_m.empty()) {
    TofImage tof{.depth_m = images.tof.depth_m, .amplitude = {}};
    rectifier.CorrectRanges(tof);
    html += "<h2>ToF points on the left image</h2>\n" +
            FigureHtml(TofPicture(left, tof, rectifier.rig()),
                       "Colours change where the board ends: red is near, blue is far.");
  }
  return html + PageEnd();
}

}  // namespace sprout::calibrate
