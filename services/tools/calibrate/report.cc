#include "services/tools/calibrate/report.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "common/core/image.h"
#include "common/geometry/projection.h"
#include "common/picture/color_map.h"
#include "common/picture/html.h"
#include "common/picture/picture.h"
#include "common/rig/rectifier.h"

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

// The figures of the whole rig.
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

constexpr int kCoverageWidth = 480;
constexpr int kPairWidth = 1400;
constexpr int kTofWidth = 1000;
constexpr double kDarker = 0.7;  // makes dots stand out
constexpr int kRows = 16;
const cv::Scalar kRowColor(60, 200, 60);
const cv::Scalar kGridColor(190, 190, 190);
// Sub-pixel positions of OpenCV's drawing: of 1/16 px.
constexpr int kShift = 4;

cv::Point Fixed(const cv::Point2d& p) {
  return {static_cast<int>(std::lround(p.x * (1 << kShift))),
          static_cast<int>(std::lround(p.y * (1 << kShift)))};
}

// A dot at a position of an image of which the picture is a smaller one.
void DrawDot(cv::Mat3b& picture, const cv::Point2d& pixel, double scale, double radius_px,
             const cv::Vec3b& color) {
  cv::circle(picture, Fixed((pixel + cv::Point2d(0.5, 0.5)) * scale),
             static_cast<int>(radius_px * (1 << kShift)), cv::Scalar(color), cv::FILLED,
             cv::LINE_AA, kShift);
}

cv::Mat3b ToWidth(const cv::Mat3b& picture, int width) {
  if (picture.cols <= width) return picture;
  cv::Mat3b small;
  cv::resize(picture, small, {width, picture.rows * width / picture.cols}, 0, 0, cv::INTER_AREA);
  return small;
}

cv::Mat3b Darkened(const cv::Mat& image, int width) {
  cv::Mat3b picture;
  ToWidth(ToBgr(ToGrey(image)), width).convertTo(picture, -1, kDarker);
  return picture;
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
  add(counts.two_sizes, "whose left and right differ in size");
  add(counts.other_size, "of another size than the first view");
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

cv::Mat3b CoveragePicture(const CameraQuality& quality, cv::Size size) {
  const double scale = static_cast<double>(kCoverageWidth) / size.width;
  cv::Mat3b picture(static_cast<int>(std::lround(size.height * scale)), kCoverageWidth,
                    cv::Vec3b(255, 255, 255));
  for (int part = 1; part < 3; ++part) {
    const int x = picture.cols * part / 3;
    const int y = picture.rows * part / 3;
    cv::line(picture, {x, 0}, {x, picture.rows}, kGridColor);
    cv::line(picture, {0, y}, {picture.cols, y}, kGridColor);
  }
  cv::rectangle(picture, cv::Rect({0, 0}, picture.size()), kGridColor);
  // rms_px is of both coordinates together.
  const ValueRange range_px{0, std::max(1e-6, 4 * quality.rms_px / std::sqrt(2.0))};
  bool clipped = false;
  for (const CornerResidual& residual : quality.residuals) {
    clipped = clipped || cv::norm(residual.error) > range_px.max;
    DrawDot(picture, residual.pixel, scale, 2, ColorOf(cv::norm(residual.error), range_px));
  }
  return ScaledPicture(picture, "", {.axes = {{range_px, "px"}}, .above = clipped});
}

cv::Mat3b PairPicture(const cv::Mat& left, const cv::Mat& right) {
  cv::Mat3b both;
  cv::hconcat(ToBgr(ToGrey(left)), ToBgr(ToGrey(right)), both);
  both = ToWidth(both, kPairWidth);
  for (int row = 1; row < kRows; ++row) {
    const int y = both.rows * row / kRows;
    cv::line(both, {0, y}, {both.cols, y}, kRowColor);
  }
  return both;
}

cv::Mat3b TofPicture(const cv::Mat& left, const TofImage& tof, const Rig& rig) {
  cv::Mat3b picture = Darkened(left, kTofWidth);
  const double scale = static_cast<double>(picture.cols) / left.cols;
  const ValueRange range_m = DepthRange(tof);
  ScaleContent content{.axes = {{range_m, "m", /*is_depth=*/true}}};
  int behind = 0;
  for (const ProjectedPoint& point : TofProjector(rig).Project(tof, behind)) {
    const float depth_m = tof.depth_m(point.tof_v, point.tof_u);
    const cv::Point2d pixel(point.seed.u, point.seed.v);
    if (!cv::Rect2d({0, 0}, cv::Size2d(left.size())).contains(pixel)) continue;
    content.above = content.above || depth_m < range_m.min;  // near is up
    content.below = content.below || depth_m > range_m.max;
    DrawDot(picture, pixel, scale, 1.5, ColorOfDepth(depth_m, range_m));
  }
  return ScaledPicture(picture, "", content);
}

cv::Mat3b DotsPicture(const cv::Mat& image, const std::vector<cv::Point2d>& places,
                      const std::vector<double>& values_px, double most_px) {
  cv::Mat3b picture = Darkened(image, kPairWidth / 2);
  const double scale = static_cast<double>(picture.cols) / image.cols;
  const ValueRange range_px{0, most_px};
  bool clipped = false;
  for (size_t i = 0; i < places.size(); ++i) {
    clipped = clipped || values_px[i] > most_px;
    DrawDot(picture, places[i], scale, 2, ColorOf(values_px[i], range_px));
  }
  return ScaledPicture(picture, "", {.axes = {{range_px, "px"}}, .above = clipped});
}

std::string VerdictText(bool is_good) { return is_good ? "good" : "not good enough"; }

std::string ReportStart(std::string_view what, const std::vector<std::string>& reasons) {
  std::string html = PageStart("Calibration of the rig");
  html += fmt::format("<h1>{}: <span class=\"{}\">{}</span></h1>\n", what,
                      reasons.empty() ? "good" : "bad", VerdictText(reasons.empty()));
  if (reasons.empty()) return html;
  html += "<ul>\n";
  for (const std::string& reason : reasons) html += "<li>" + EscapedHtml(reason) + "</li>\n";
  return html + "</ul>\n";
}

}  // namespace sprout::calibrate
