#include "services/tools/quality/program.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "common/app/output_paths.h"
#include "common/app/program.h"
#include "common/app/version.h"
#include "common/bus/lcm_url.h"
#include "common/config/config_error.h"
#include "common/core/number_text.h"
#include "common/picture/color_map.h"
#include "common/picture/html.h"
#include "common/picture/picture.h"
#include "services/tools/quality/sources.h"
#include "services/tools/quality/verdict.h"

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

std::string Lines(const std::string& text) {
  std::string html;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) html += "<p>" + EscapedHtml(line) + ".</p>\n";
  return html;
}

constexpr int kMinSide = 240;  // px; smaller regions are shown larger

// Shows every pixel of a small picture as a square.
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

void DrawRect(cv::Mat3b& picture, const cv::Rect& rect) {
  const int width = std::max(1, picture.cols / 400);
  const cv::Rect outer(rect.x - width, rect.y - width, rect.width + 2 * width,
                       rect.height + 2 * width);
  cv::rectangle(picture, outer, {0, 0, 0}, 3 * width);
  cv::rectangle(picture, outer, {255, 255, 255}, width);
}

// The newest disparity map, with the region, and the edge, as white frames.
cv::Mat3b RegionPicture(const Measurement& measurement) {
  const TargetMeter& meter = measurement.meter();
  const cv::Mat1f& px = measurement.newest_px();
  std::vector<float> values;
  for (const float d : px) {
    if (std::isfinite(d)) values.push_back(d);
  }
  const ValueRange range = RobustRange(std::move(values));
  cv::Mat3b picture = Colorize(px, range);
  DrawRect(picture, meter.region());
  if (meter.edge()) DrawRect(picture, *meter.edge());
  return ScaledPicture(picture, "Disparity and region", DisparityScale(range, &meter.pair()));
}

// Picture of the region: depth less that of the plane, mean of the frames, mm. Green lies on the
// plane, blue is nearer, red farther; the scale reaches to three times the RMS.
// @param maps  the meter's.
cv::Mat3b ResidualPicture(const TargetMaps& maps, const TargetQuality& quality) {
  const double reach_mm = RoundStep(std::max(1e-3, 3 * quality.plane_rms_mm.value_or(1)));
  const ValueRange range{.min = -reach_mm, .max = reach_mm};
  return ScaledPicture(Enlarged(Colorize(maps.residual_mm, range)), "Depth minus plane, mean",
                       Scale(range, maps.residual_mm));
}

// Picture of the region: standard deviation of each pixel over the frames, mm. The scale ends at
// twice the 95 % figure.
cv::Mat3b NoisePicture(const TargetMaps& maps, const TargetQuality& quality) {
  const ValueRange range{
      .min = 0, .max = RoundStep(std::max(1e-3, 2 * quality.temporal_noise_95_mm.value_or(1)))};
  return ScaledPicture(Enlarged(Colorize(maps.noise_mm, range)), "Temporal noise",
                       Scale(range, maps.noise_mm));
}

// The whole measurement as a page that is one file: figures with limits and meanings, where it was
// measured, the plane, residuals and noise as pictures and histograms. The same measurement gives
// the same bytes.
// @param input  what was measured. @pre !measurement.empty().
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
          HistogramSvg("depth minus plane, mean of the frames, mm",
                       {maps.residual_mm.begin(), maps.residual_mm.end()}, {});
  if (quality.temporal_noise_mm) {
    html += "<h2>Temporal noise</h2>\n" +
            FigureHtml(NoisePicture(maps, quality),
                       "Standard deviation of each pixel over the frames; black: not always a "
                       "depth.") +
            HistogramSvg("standard deviation over the frames, mm",
                         {maps.noise_mm.begin(), maps.noise_mm.end()}, {});
  }
  return html + PageEnd();
}

namespace fs = std::filesystem;

constexpr char kDescription[] =
    "How good depth is on a flat target: point the rig at a wall or a board that stands still.\n"
    "Measures a running graph (without INPUT), a log, or a folder of disparity maps.";

constexpr char kFooter[] = R"(
Examples
  sprout-quality                                            the running graph, until Ctrl-C
  sprout-quality run.lcm --distance-m 1.204 --report q.html a recording, with a page to look at
  sprout-quality --once --limits limits.textproto           a production line: exit code 0 or 1
  sprout-quality maps --calib calib.txt                     PFM files, in px

limits.textproto: limit { figure: "fill_rate_percent" at_least: 98 }
                  limit { figure: "plane_rms_percent" at_most: 0.5 }

Exit codes: 0; 1 a limit is not kept, or nothing could be measured; 2 a flag, a file or a region
that cannot be used.
)";

struct Options {
  fs::path input;
  std::string region;
  std::string edge;
  TargetSettings settings;
  double distance_m = 0;
  std::string frames;
  fs::path calibration;
  fs::path limits;
  fs::path json;
  fs::path report;
  LiveOptions live{.lcm_url = kDefaultLcmUrl, .prefix = {}};
};

void AddMeasureFlags(Flags& flags, Options& options) {
  flags
      .Add("INPUT", options.input,
           "Log of a graph (SPROUT_DISPARITY, SPROUT_RIG), or folder of disparity maps "
           "(*disparity.pfm, else *.pfm; px); without it: the running graph")
      .ExistingPath();
  flags.Add("--region LEFT,TOP,WIDTH,HEIGHT", options.region,
            "Part of the left image that shows the target alone, px (default: its middle "
            "half each way)");
  flags.Add("--edge LEFT,TOP,WIDTH,HEIGHT", options.edge,
            "Part of the left image that one depth edge crosses, such as the border of a "
            "board before a wall, px: how wide the edge is");
  flags
      .Add("--distance-m", options.distance_m,
           "True distance of the target from the left camera, square to the target, m")
      .Within(0.001, 10000);
  flags
      .Add("--count", options.settings.count,
           "Maps that are measured: the first ones, of a running graph the newest")
      .WithinWhole(1, 1000)
      .ShowDefault();
  flags.Add("--frames A:B", options.frames, "Of a log: frames by number, both included");
  flags.Add("--calib FILE", options.calibration,
            "Of a folder: calibration in Middlebury's format: cam0, cam1 (px), baseline (mm) "
            "(default: its calib.txt)");
}

void AddOutputFlags(Flags& flags, Options& options) {
  flags.Add("--limits FILE", options.limits,
            "What figures have to keep; exit code 1 when one does not");
  flags.Add("--json FILE", options.json, "Write the figures as JSON");
  flags.Add("--report FILE", options.report, "Write an HTML page: figures, plane, residuals");
  flags.Add("--once", options.live.once,
            "Of a running graph: ends when --count maps are measured, or when none came for 30 s");
  flags
      .Add("--lcm-url URL", options.live.lcm_url,
           "Where the messages travel: udpm://GROUP:PORT?ttl=0 or tcpq://HOST:PORT")
      .Environment("LCM_DEFAULT_URL")
      .ShowDefault();
  flags.Add("--channel-prefix TEXT", options.live.prefix, "Before the channels of the graph");
}

cv::Rect RectOf(const std::string& flag, const std::string& text) {
  const auto numbers = ParseNumbers<int>(',', text);
  if (!numbers || numbers->size() != 4) {
    throw ConfigError(flag + " " + text + ": allowed is LEFT,TOP,WIDTH,HEIGHT in whole px");
  }
  return {numbers->at(0), numbers->at(1), numbers->at(2), numbers->at(3)};
}

// A measurement as the flags ask for it. Its constructor checks everything that can be wrong.
class Run {
 public:
  explicit Run(const Options& options) : options_(options), measurement_(SettingsOf(options)) {
    if (!options.limits.empty()) limits_ = LoadLimits(options.limits);
    NoteFolder();
    if (!options.json.empty()) RequireWritableFile("--json", options.json);
    if (!options.report.empty()) RequireWritableFile("--report", options.report);
    RequireChannelPrefix(options.live.prefix);
  }

  int Measure() {
    const std::string complaint = Read();
    if (!complaint.empty()) std::cerr << "sprout-quality: " << complaint << "\n";
    const std::string left_out = measurement_.LeftOutText();
    if (!left_out.empty()) std::cerr << "sprout-quality: " << left_out << "\n";
    const TargetQuality quality = measurement_.meter().Quality();
    const std::string input = InputText();
    if (!options_.json.empty()) WriteWhole(options_.json, JsonText(measurement_, limits_, input));
    if (!options_.report.empty()) {
      WriteWhole(options_.report, ReportHtml(measurement_, limits_, input));
    }
    std::cout << TableText(measurement_, limits_) << MissingText(quality, measurement_.settings());
    return IsGood(quality, limits_) ? 0 : 1;
  }

 private:
  static TargetSettings SettingsOf(const Options& options) {
    TargetSettings settings = options.settings;
    if (!options.region.empty()) settings.region = RectOf("--region", options.region);
    if (!options.edge.empty()) settings.edge = RectOf("--edge", options.edge);
    if (options.distance_m > 0) settings.distance_m = options.distance_m;
    return settings;
  }

  // Notes the inputs, so that no output may replace one.
  void NoteFolder() const {
    if (!fs::is_directory(options_.input)) return;
    NoteFolderFiles(options_.input, options_.calibration);
  }

  std::string Read() {
    if (options_.input.empty()) {
      MeasureGraph(options_.live, measurement_, [this] { Refresh(); });
      return "";
    }
    if (fs::is_directory(options_.input)) {
      MeasureFolder(options_.input, options_.calibration, measurement_);
      return "";
    }
    return MeasureLog(options_.input, options_.live.prefix, options_.frames, measurement_);
  }

  std::string InputText() const {
    return options_.input.empty() ? "the running graph" : options_.input.string();
  }

  void Refresh() {
    if (isatty(STDOUT_FILENO) == 0) return;
    constexpr std::string_view kHome = "\x1b[H\x1b[J";  // cursor to the corner, rest empty
    std::cout << kHome << TableText(measurement_, limits_) << std::flush;
  }

  const Options& options_;
  Measurement measurement_;
  std::vector<Limit> limits_;
};

}  // namespace

int QualityMain(int argc, const char* const* argv) {
  Flags flags("sprout-quality", kDescription);
  Options options;
  AddMeasureFlags(flags, options);
  AddOutputFlags(flags, options);
  flags.SetFooter(kFooter);
  return RunProgram(flags, argc, argv,
                    [&] { return RefusingLogs([&] { return Run(options).Measure(); }); });
}

}  // namespace sprout::quality
