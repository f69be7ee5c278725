#include "services/batch/report.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "common/picture/chart.h"
#include "common/picture/html.h"
#include "common/quality/frame_quality.h"
#include "services/batch/frame_commands.h"
#include "services/batch/frame_rows.h"
#include "services/batch/report_losses.h"
#include "services/batch/report_pictures.h"
#include "services/batch/tables.h"
#include "services/batch/text_file.h"

namespace sprout::batch {
namespace {

namespace fs = std::filesystem;

constexpr size_t kShownFrames = 8;

constexpr char kHead[] = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>sprout-batch</title>
<style>
body { font: 15px/1.45 sans-serif; max-width: 1500px; margin: 1.5em auto; padding: 0 1.2em; color: #1c1c1c; }
h1 { font-size: 1.6em; margin-bottom: .2em; } h2 { margin-top: 1.8em; border-bottom: 1px solid #ccc; }
h3 { font-size: 1em; margin: 1.4em 0 .2em; }
table { border-collapse: collapse; margin: .6em 0; }
th, td { border-bottom: 1px solid #e2e2e2; padding: .22em .9em .22em 0; text-align: right; }
th { color: #555; font-weight: normal; } th:first-child, td:first-child { text-align: left; }
td.strip { text-align: left; } td:first-child { white-space: nowrap; } td.none { color: #bbb; }
.better { color: #176117; } .worse, .bad { color: #a31515; }
.chart { display: inline-block; margin: .4em 1.6em .8em 0; } .chart figcaption { color: #444; }
.chart text { font: 11px sans-serif; fill: #555; } .axis { stroke: #999; }
.a { fill: #9dbbd8; } .b { fill: none; stroke: #c2540a; stroke-width: 1.8; }
.strip polygon { fill: #c2540a; } svg.strip { background: #f4f1ee; vertical-align: middle; }
.both { fill: #a9a49c; }
.pictures img { vertical-align: top; margin: 0 8px 4px 0; border: 1px solid #ddd; width: calc(25% - 14px); }
pre { background: #f5f5f3; padding: .5em .8em; overflow-x: auto; font-size: 12.5px; }
details { margin: .2em 0 1em; } summary { cursor: pointer; color: #444; }
.key { display: inline-block; width: 1em; height: .7em; margin: 0 .3em 0 1em; }
</style></head><body>
)";

std::string Number(double value) { return std::isnan(value) ? "-" : fmt::format("{:.4g}", value); }

std::vector<std::string> LinesOf(const fs::path& path) {
  std::istringstream file(ReadText(path).value_or(""));
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

class ReportWriter {
 public:
  ReportWriter(const BatchFolder& folder, const Manifest& manifest, const BatchState& state,
               const std::string& program)
      : folder_(folder),
        manifest_(manifest),
        state_(state),
        programs_(fs::path(program).parent_path()),
        rows_(folder.table()),
        pictures_(folder, manifest),
        has_b_(manifest.head.variants.size() > 1) {}

  std::string Html() {
    std::string html = kHead + Summary() + Means();
    if (has_b_) html += ConfigChange();
    html += LossesHtml(folder_, manifest_, state_) + Distributions() + Logs();
    if (has_b_) html += Frames("The most changed frames", "moved", /*lowest=*/false);
    const std::string last = has_b_ ? "b_" : "a_";
    const bool has_truth = !std::isnan(MeanOf(rows_.Column(last + "bad1")));
    html += has_truth ? Frames("The worst frames, against the truth", last + "bad1", false)
                      : Frames("The worst frames", last + "score", true);
    return html + Commands() + "</body></html>\n";
  }

 private:
  std::string Summary() const {
    std::string html =
        fmt::format("<h1>{} log{}, {} frames: {}</h1>\n", manifest_.logs.size(),
                    manifest_.logs.size() == 1 ? "" : "s", rows_.rows().size(), Verdict());
    for (const Variant& variant : manifest_.head.variants) {
      std::set<std::string> versions;
      for (const auto& [stage, program] : variant.programs) versions.insert(program.version);
      std::string text;
      for (const std::string& version : versions) text += (text.empty() ? "" : ", ") + version;
      html += fmt::format(
          "<div><b>{}</b>: configuration {} (<a href=\"config_{}.textproto\">all of it</a>), "
          "{}</div>\n",
          variant.name == "a" ? "A" : "B", EscapedHtml(variant.config_digest),
          EscapedHtml(variant.name), EscapedHtml(text));
    }
    if (state_.missing > 0) {
      html += fmt::format(
          "<p class=\"bad\">{} of {} shards are missing: this is a part of the batch.</p>\n",
          state_.missing, manifest_.shards.size());
    }
    for (const std::string& log : manifest_.head.left_out) {
      html +=
          fmt::format("<p class=\"bad\">Left out, because of its name: {}</p>\n", EscapedHtml(log));
    }
    return html;
  }

  std::string Verdict() const {
    if (!has_b_) return "one configuration";
    const std::vector<float> changed = rows_.Column("changed");
    const std::vector<float> moved = rows_.Column("moved");
    const auto touched =
        std::count_if(changed.begin(), changed.end(), [](float x) { return x > 0; });
    if (touched == 0) return "A and B give the same maps";
    return fmt::format("{} frames differ; {:.2f} % of the pixels move by more than 1 px", touched,
                       100 * MeanOf(moved));
  }

  std::vector<std::string> Measures() const {
    std::vector<std::string> measures = MeasureColumns();
    measures.emplace_back("bad1");
    for (const std::string& stage : manifest_.head.stages) measures.push_back(stage + "_ms");
    return measures;
  }

  static bool MoreIsBetter(const std::string& measure) {
    const QualityColumn* column = FindQualityColumn(measure);
    return column != nullptr && column->more_is_better;
  }

  static std::string Meaning(const std::string& measure) {
    if (measure == "bad1")
      return "share of pixels with ground truth that are off by more than 1 px or have no "
             "disparity";
    if (measure.ends_with("_ms")) {
      return "time a frame, mean of its shard; depends on what else the machine did";
    }
    const QualityColumn* column = FindQualityColumn(measure);
    return column == nullptr ? "" : std::string(column->meaning);
  }

  // Times are not coloured: they depend on what else the machines did.
  static std::string Difference(const std::string& measure, double a, double b) {
    if (std::isnan(b - a)) return "<td>-</td>";
    if (std::abs(b - a) < 1e-9) return "<td class=\"none\">0</td>";
    const char* kind = measure.ends_with("_ms")               ? ""
                       : MoreIsBetter(measure) == (b - a > 0) ? "better"
                                                              : "worse";
    return fmt::format("<td class=\"{}\">{:+.3g}</td>", kind, b - a);
  }

  std::string Means() const {
    std::string html = "<h2>What changed</h2>\n<table><tr><th>mean over all frames</th><th>A</th>";
    if (has_b_) html += "<th>B</th><th>B &minus; A</th>";
    html += "<th></th></tr>\n";
    for (const std::string& measure : Measures()) {
      const double a = MeanOf(rows_.Column("a_" + measure));
      const double b = MeanOf(rows_.Column("b_" + measure));
      if (std::isnan(a) && std::isnan(b)) continue;
      html += fmt::format("<tr><td>{}</td><td>{}</td>", measure, Number(a));
      if (has_b_) {
        html += fmt::format("<td>{}</td>", Number(b)) + Difference(measure, a, b);
      }
      html += fmt::format("<td style=\"text-align:left;color:#666\">{}</td></tr>\n",
                          EscapedHtml(Meaning(measure)));
    }
    html += "</table>\n";
    if (has_b_ && std::isnan(MeanOf(rows_.Column("a_confidence"))) !=
                      std::isnan(MeanOf(rows_.Column("b_confidence")))) {
      html +=
          "<p class=\"bad\">Only one of the two gives a confidence, which is a factor of the "
          "score: their scores do not compare.</p>\n";
    }
    return html;
  }

  std::string ConfigChange() const {
    const std::vector<std::string> a = LinesOf(folder_.config("a"));
    const std::vector<std::string> b = LinesOf(folder_.config("b"));
    std::string text;
    // Both print every field in one order, so lines are counterparts.
    for (size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
      const std::string in_a = i < a.size() ? a[i] : "";
      const std::string in_b = i < b.size() ? b[i] : "";
      if (in_a != in_b) text += "A " + in_a + "\nB " + in_b + "\n";
    }
    if (text.empty()) return "<p>The configurations are the same; the programs differ.</p>\n";
    return "<p>The configurations differ in</p>\n<pre>" + EscapedHtml(text) + "</pre>\n";
  }

  std::string Distributions() const {
    std::string html = "<h2>Distributions over the frames</h2>\n";
    html += "<p><span class=\"key\" style=\"background:#9dbbd8\"></span>A";
    if (has_b_) html += "<span class=\"key\" style=\"background:#c2540a;height:.2em\"></span>B";
    html += "</p>\n";
    if (has_b_) {
      html += HistogramSvg("share of pixels that move by more than 1 px", rows_.Column("moved"), {},
                           "both");
      html += HistogramSvg("mean change, px", rows_.Column("mean_change_px"), {}, "both");
    }
    for (const std::string& measure : Measures()) {
      html += HistogramSvg(measure, rows_.Column("a_" + measure), rows_.Column("b_" + measure));
    }
    return html;
  }

  // What is shown of a log.
  struct LogLine {
    std::string name;
    size_t first;
    size_t last;
    double key;  // logs are sorted by it, the largest first
  };

  std::string Logs() const {
    const std::vector<float> score_a = rows_.Column("a_score");
    const std::vector<float> score = has_b_ ? rows_.Column("b_score") : score_a;
    const std::vector<float> key = has_b_ ? rows_.Column("moved") : score;
    std::vector<LogLine> lines;
    for (size_t i = 0; i < rows_.rows().size();) {
      size_t end = i;
      while (end < rows_.rows().size() && rows_.rows()[end].log == rows_.rows()[i].log) ++end;
      const double mean = key.empty() ? 0 : Mean(key, i, end);
      lines.push_back({rows_.logs()[rows_.rows()[i].log], i, end, has_b_ ? mean : -mean});
      i = end;
    }
    std::stable_sort(lines.begin(), lines.end(),
                     [](const LogLine& x, const LogLine& y) { return x.key > y.key; });
    std::string html = "<h2>Where</h2>\n";
    if (has_b_) html += "<p>Moved: share of the pixels that move by more than 1 px.</p>\n";
    html += "<table><tr><th>log</th><th>frames</th>";
    if (has_b_) html += "<th>moved</th><th>score A</th>";
    html += fmt::format("<th>score {}</th><th>{} along the log</th></tr>\n", has_b_ ? "B" : "A",
                        has_b_ ? "moved" : "1 &minus; score");
    std::vector<float> strip = key;
    if (!has_b_) {
      for (float& value : strip) value = 1 - value;
    }
    double top = 1e-6;
    for (const float value : strip) top = std::isnan(value) ? top : std::max(top, double{value});
    for (size_t i = 0; i < std::min(lines.size(), kShownLogs); ++i) {
      html += LogRow(lines[i], key, score_a, score, strip, top);
    }
    html += "</table>\n";
    if (lines.size() > kShownLogs) {
      html += fmt::format("<p>{} more logs are in frames.csv.</p>\n", lines.size() - kShownLogs);
    }
    return html;
  }

  std::string LogRow(const LogLine& line, const std::vector<float>& key,
                     const std::vector<float>& score_a, const std::vector<float>& score,
                     const std::vector<float>& strip, double top) const {
    const auto from = static_cast<std::ptrdiff_t>(line.first);
    const auto to = static_cast<std::ptrdiff_t>(line.last);
    std::string html = fmt::format("<tr><td>{}</td><td>{}</td>", EscapedHtml(line.name), to - from);
    if (has_b_) {
      html += fmt::format("<td>{}</td><td>{}</td>",
                          Number(key.empty() ? NAN : Mean(key, line.first, line.last)),
                          Number(Mean(score_a, line.first, line.last)));
    }
    html += fmt::format("<td>{}</td>", Number(Mean(score, line.first, line.last)));
    if (strip.empty()) return html + "<td></td></tr>\n";
    return html + "<td class=\"strip\">" +
           StripSvg({strip.begin() + from, strip.begin() + to}, top) + "</td></tr>\n";
  }

  static double Mean(const std::vector<float>& values, size_t from, size_t to) {
    if (values.empty()) return NAN;
    return MeanOf({values.begin() + static_cast<std::ptrdiff_t>(from),
                   values.begin() + static_cast<std::ptrdiff_t>(to)});
  }

  static std::string InWords(const std::string& column, double value) {
    if (column == "moved") {
      return fmt::format("{:.2f} % of the pixels move by more than 1 px", 100 * value);
    }
    if (column.ends_with("bad1")) {
      return fmt::format("{:.2f} % of the true pixels are off by more than 1 px or missing",
                         100 * value);
    }
    return fmt::format("score {:.3f}", value);
  }

  std::string Frames(const std::string& title, const std::string& column, bool lowest) {
    const std::vector<float> values = rows_.Column(column);
    std::vector<size_t> order;
    for (size_t i = 0; i < values.size(); ++i) {
      if (!std::isnan(values[i]) && (lowest || values[i] > 0)) order.push_back(i);
    }
    const size_t shown = std::min(kShownFrames, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(shown),
                      order.end(), [&](size_t x, size_t y) {
                        if (values[x] == values[y]) return x < y;
                        return lowest ? values[x] < values[y] : values[x] > values[y];
                      });
    if (shown == 0) return "";
    std::string html = "<h2>" + title + "</h2>\n";
    if (has_b_) {
      html +=
          "<p>|A - B|: grey where they agree, blue to red up to 2 px and more, white where "
          "only one has a disparity.</p>\n";
    }
    for (size_t i = 0; i < shown; ++i) {
      const FrameRow& row = rows_.rows()[order[i]];
      html += fmt::format("<h3>{}, frame {}: {}</h3>\n", EscapedHtml(rows_.logs()[row.log]),
                          row.seq, InWords(column, values[order[i]]));
      html += pictures_.HtmlOf(row.shard, row.seq, row.utime);
      html += "<details><summary>look at it, compute it again</summary><pre>" +
              EscapedHtml(CommandsOf(row)) + "</pre></details>\n";
    }
    return html;
  }

  std::string CommandsOf(const FrameRow& row) const {
    const Shard& shard = manifest_.shards[row.shard];
    return FrameCommands(folder_, manifest_.head, manifest_.logs[static_cast<size_t>(shard.log)],
                         row.seq, programs_);
  }

  std::string Commands() const {
    return "<h2>Files</h2>\n<p><a href=\"frames.csv\">frames.csv</a>: a row a frame, with all "
           "figures. logs/NAME_a.lcm, NAME_b.lcm: the answers. manifest.jsonl: shards, digests, "
           "programs.</p>\n";
  }

  const BatchFolder& folder_;
  const Manifest& manifest_;
  const BatchState& state_;
  fs::path programs_;
  FrameRows rows_;
  ReportPictures pictures_;
  bool has_b_;
};

}  // namespace

void WriteReport(const BatchFolder& folder, const Manifest& manifest, const BatchState& state,
                 const std::string& program) {
  OutputFile file(folder.report());
  file.Write(ReportWriter(folder, manifest, state, program).Html());
  CommitFile(folder.report(), file);
}

}  // namespace sprout::batch
