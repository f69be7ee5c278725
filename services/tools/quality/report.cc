#include "services/tools/quality/report.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <vector>

#include "common/app/version.h"
#include "common/picture/color_map.h"
#include "common/picture/html.h"
#include "common/picture/picture.h"

namespace sprout::quality {
namespace {

constexpr char kStyle[] = R"(figure { max-width: 46em; } td.meaning { color: #555; }
td.number { text-align: right; font-variant-numeric: tabular-nums; } .bad { font-weight: 600; }
)";

std::string FigureRows(const TargetQuality& quality, std::span<const Limit> limits) {
  std::string html =
      "<table><tr><th>figure</th><th>value</th><th>allowed</th><th></th><th>meaning</th></tr>\n";
  for (const TargetFigure& figure : TargetFigures()) {
    const auto limit = std::ranges::find(limits, &figure, &Limit::figure);
    const bool limited = limit != limits.end();
    const bool kept = limited && limit->IsKept(quality);
    html += fmt::format(
        "<tr><td>{}</td><td class=\"number\">{}</td><td>{}</td><td class=\"{}\">{}</td>"
        "<td class=\"meaning\">{}</td></tr>\n",
        EscapedHtml(figure.title), EscapedHtml(TargetText(figure, quality)),
        limited ? EscapedHtml(limit->Text()) : "", kept ? "good" : "bad",
        !limited ? "" : (kept ? "good" : "bad"), EscapedHtml(figure.meaning));
  }
  return html + "</table>\n";
}

std::string Heading(const TargetQuality& quality, std::span<const Limit> limits) {
  if (limits.empty()) return "<h1>Depth on a flat target</h1>\n";
  const bool good = IsGood(quality, limits);
  return fmt::format("<h1>Depth on a flat target: <span class=\"{0}\">{0}</span></h1>\n",
                     good ? "good" : "bad");
}

std::string PlaneText(const TargetMeter& meter, const TargetMaps& maps) {
  const auto plane = maps.plane ? PlaneInSpace(*maps.plane, meter.pair()) : std::nullopt;
  if (!plane) return "<p class=\"bad\">No plane was found.</p>\n";
  const Eigen::Vector3d normal = plane->normal();
  return fmt::format(
      "<p>{:+.6f} x {:+.6f} y {:+.6f} z = {:.5f} m in the frame of the left camera (x right, y "
      "down, z forward); as disparity {:.4f} px {:+.6f} u {:+.6f} v.</p>\n",
      normal.x(), normal.y(), normal.z(), -plane->offset(), maps.plane->d0, maps.plane->du,
      maps.plane->dv);
}

std::vector<float> Present(const cv::Mat1f& values) {
  std::vector<float> present;
  for (const float value : values) {
    if (!std::isnan(value)) present.push_back(value);
  }
  return present;
}

std::string Lines(const std::string& text) {
  std::string html;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) html += "<p>" + EscapedHtml(line) + ".</p>\n";
  return html;
}

constexpr int kMinSide = 240;  // px; smaller regions are shown larger

// Every pixel a square.
cv::Mat3b Enlarged(const cv::Mat3b& picture) {
  const int factor = std::max(1, kMinSide / std::max(1, std::min(picture.cols, picture.rows)));
  if (factor == 1) return picture;
  cv::Mat3b large;
  cv::resize(picture, large, {}, factor, factor, cv::INTER_NEAREST);
  return large;
}

ScaleContent Scale(const ValueRange& range, const cv::Mat1f& values) {
  ScaleContent content{.axes = {{.range = range, .unit = "mm"}}};
  for (const float value : values) {
    content.above = content.above || value > range.max;
    content.below = content.below || value < range.min;
  }
  return content;
}

void Frame(cv::Mat3b& picture, const cv::Rect& rect) {
  const int width = std::max(1, picture.cols / 400);
  const cv::Rect outer(rect.x - width, rect.y - width, rect.width + 2 * width,
                       rect.height + 2 * width);
  cv::rectangle(picture, outer, {0, 0, 0}, 3 * width);
  cv::rectangle(picture, outer, {255, 255, 255}, width);
}

}  // namespace

std::string ReportHtml(const Measurement& measurement, std::span<const Limit> limits,
                       const std::string& input) {
  const TargetMeter& meter = measurement.meter();
  const TargetQuality quality = meter.Quality();
  const TargetMaps maps = meter.Maps();
  const cv::Rect& region = meter.region();
  std::string html = PageStart("sprout-quality", kStyle) + Heading(quality, limits);
  html +=
      fmt::format("<p>{}: {} frames, region {},{},{},{} of {} × {} px. sprout-quality {}.</p>\n",
                  EscapedHtml(input), quality.frames, region.x, region.y, region.width,
                  region.height, meter.pair().width, meter.pair().height, EscapedHtml(Version()));
  html += Lines(measurement.LeftOutText());
  html += FigureRows(quality, limits) + Lines(MissingText(quality, measurement.settings()));
  html += "<h2>Plane</h2>\n" + PlaneText(meter, maps) +
          FigureHtml(RegionPicture(measurement), "The newest map, and where it was measured.");
  html += "<h2>Residuals</h2>\n" +
          FigureHtml(ResidualPicture(maps, quality),
                     "Depth minus that of the plane, mean of the frames: green lies on it, blue is "
                     "nearer, red farther.") +
          HistogramSvg("depth minus plane, mean of the frames, mm", Present(maps.residual_mm), {});
  if (quality.temporal_noise_mm) {
    html += "<h2>Temporal noise</h2>\n" +
            FigureHtml(NoisePicture(maps, quality),
                       "Standard deviation of each pixel over the frames; black: not always a "
                       "depth.") +
            HistogramSvg("standard deviation over the frames, mm", Present(maps.noise_mm), {});
  }
  return html + PageEnd();
}

cv::Mat3b RegionPicture(const Measurement& measurement) {
  const TargetMeter& meter = measurement.meter();
  const cv::Mat1f& px = measurement.newest_px();
  std::vector<float> values;
  for (const float d : px) {
    if (std::isfinite(d)) values.push_back(d);
  }
  const ValueRange range = RobustRange(std::move(values));
  cv::Mat3b picture = Colorize(px, range);
  Frame(picture, meter.region());
  if (meter.edge()) Frame(picture, *meter.edge());
  return ScaledPicture(picture, "Disparity and region", DisparityScale(range, &meter.pair()));
}

cv::Mat3b ResidualPicture(const TargetMaps& maps, const TargetQuality& quality) {
  const double reach_mm = RoundStep(std::max(1e-3, 3 * quality.plane_rms_mm.value_or(1)));
  const ValueRange range{.min = -reach_mm, .max = reach_mm};
  return ScaledPicture(Enlarged(Colorize(maps.residual_mm, range)), "Depth minus plane, mean",
                       Scale(range, maps.residual_mm));
}

cv::Mat3b NoisePicture(const TargetMaps& maps, const TargetQuality& quality) {
  const ValueRange range{
      .min = 0, .max = RoundStep(std::max(1e-3, 2 * quality.temporal_noise_95_mm.value_or(1)))};
  return ScaledPicture(Enlarged(Colorize(maps.noise_mm, range)), "Temporal noise",
                       Scale(range, maps.noise_mm));
}

}  // namespace sprout::quality
