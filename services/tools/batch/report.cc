#include "services/tools/batch/report.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "common/core/read_text.h"
#include "common/picture/chart.h"
#include "common/picture/html.h"
#include "services/tools/batch/report_frames.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

constexpr char kStyle[] = R"(body { max-width: 1500px; }
h3 { font-size: 1em; margin: 1.4em 0 .2em; }
th, td { text-align: right; } th:first-child, td:first-child { text-align: left; white-space: nowrap; }
td.strip { text-align: left; } td.none { color: #bbb; }
.better { color: #176117; } .worse { color: #a31515; }
.b { fill: none; stroke: #c2540a; stroke-width: 1.8; } .both { fill: #a9a49c; }
.strip polygon { fill: #c2540a; } svg.strip { background: #f4f1ee; vertical-align: middle; }
.pictures img { vertical-align: top; margin: 0 8px 4px 0; width: calc(25% - 14px); }
pre { background: #f5f5f3; padding: .5em .8em; overflow-x: auto; font-size: 12.5px; }
details { margin: .2em 0 1em; } summary { cursor: pointer; color: #444; }
.key { display: inline-block; width: 1em; height: .7em; margin: 0 .3em 0 1em; }
)";

// How the variants differ, in some words.
std::string Verdict(const FrameTable& frames) {
  const std::vector<float> changed = frames.Column("changed");
  const auto touched = std::ranges::count_if(changed, [](float x) { return x > 0; });
  if (touched == 0) return "A and B give the same maps";
  return fmt::format("{} frames differ; {:.2f} % of the pixels move by more than 1 px", touched,
                     100 * MeanOf(frames.Column("moved")));
}

std::string SummaryHtml(const Manifest& manifest, const BatchState& state,
                        const FrameTable& frames) {
  std::string html =
      fmt::format("<h1>{} log{}, {} frames: {}</h1>\n", manifest.log_size(),
                  manifest.log_size() == 1 ? "" : "s", frames.size(),
                  manifest.variant_size() > 1 ? Verdict(frames) : "one configuration");
  for (int i = 0; i < manifest.variant_size(); ++i) {
    std::set<std::string> versions;
    for (const StageProgram& program : manifest.variant(i).program()) {
      versions.insert(program.version());
    }
    html += fmt::format(
        "<div><b>{}</b>: configuration {} (<a href=\"config_{}.textproto\">all of it</a>)",
        i == 0 ? "A" : "B", manifest.variant(i).config_digest(), VariantName(i));
    for (const std::string& version : versions) html += ", " + EscapedHtml(version);
    html += "</div>\n";
  }
  if (state.missing > 0) {
    html += fmt::format(
        "<p class=\"bad\">{} of {} logs are missing: this is a part of the batch.</p>\n",
        state.missing, manifest.log_size());
  }
  for (const std::string& log : manifest.left_out()) {
    html +=
        fmt::format("<p class=\"bad\">Left out, because of its name: {}</p>\n", EscapedHtml(log));
  }
  return html;
}

std::vector<std::string> LinesOf(const fs::path& path) {
  std::istringstream file(ReadText(path).value_or(""));
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::string ConfigChangeHtml(const BatchFolder& folder) {
  std::vector<std::string> a = LinesOf(folder.config(0));
  std::vector<std::string> b = LinesOf(folder.config(1));
  a.resize(std::max(a.size(), b.size()));
  b.resize(a.size());
  std::string text;
  // Both print every field in one order, so lines are counterparts.
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i] != b[i]) text += "A " + a[i] + "\nB " + b[i] + "\n";
  }
  if (text.empty()) return "<p>The configurations are the same; the programs differ.</p>\n";
  return "<p>The configurations differ in</p>\n<pre>" + EscapedHtml(text) + "</pre>\n";
}

std::string DistributionsHtml(const Manifest& manifest, const FrameTable& frames) {
  const bool has_b = manifest.variant_size() > 1;
  std::string html = "<h2>Distributions over the frames</h2>\n";
  html += "<p><span class=\"key\" style=\"background:#9dbbd8\"></span>A";
  if (has_b) html += "<span class=\"key\" style=\"background:#c2540a;height:.2em\"></span>B";
  html += "</p>\n";
  if (has_b) {
    html += HistogramSvg("share of pixels that move by more than 1 px", frames.Column("moved"), {},
                         "both");
    html += HistogramSvg("mean change, px", frames.Column("mean_change_px"), {}, "both");
  }
  for (const std::string& measure : ShownMeasures(manifest)) {
    html += HistogramSvg(measure, frames.Column("a_" + measure), frames.Column("b_" + measure));
  }
  return html;
}

}  // namespace

void WriteReport(const BatchFolder& folder, const Manifest& manifest, const BatchState& state,
                 const FrameTable& frames, const std::string& program) {
  const bool has_b = manifest.variant_size() > 1;
  std::string html = PageStart("sprout-batch", kStyle) + SummaryHtml(manifest, state, frames) +
                     MeansHtml(manifest, frames);
  if (has_b) html += ConfigChangeHtml(folder);
  html += LossesHtml(folder, manifest, state) + DistributionsHtml(manifest, frames) +
          LogsHtml(manifest, frames);
  ReportFrames shown(folder, manifest, frames, fs::path(program).parent_path());
  if (has_b) html += shown.Html("The most changed frames", "moved", /*lowest=*/false);
  const std::string last = has_b ? "b_" : "a_";
  const bool has_truth = !std::isnan(MeanOf(frames.Column(last + "bad1")));
  html += has_truth ? shown.Html("The worst frames, against the truth", last + "bad1", false)
                    : shown.Html("The worst frames", last + "score", true);
  html +=
      "<h2>Files</h2>\n<p><a href=\"frames.csv\">frames.csv</a>: a row a frame, with all figures. "
      "logs/NAME_a.lcm, NAME_b.lcm: the answers. manifest.textproto: logs, programs, "
      "digests.</p>\n";
  WriteText(folder.report(), html + PageEnd());
}

}  // namespace sprout::batch
