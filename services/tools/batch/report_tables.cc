#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/measure/frame_quality.h"
#include "common/picture/chart.h"
#include "common/picture/html.h"
#include "services/tools/batch/measures.h"
#include "services/tools/batch/report.h"

namespace sprout::batch {
namespace {

std::string Number(double value) { return std::isnan(value) ? "-" : fmt::format("{:.4g}", value); }

bool MoreIsBetter(const std::string& measure) {
  const QualityColumn* column = FindQualityColumn(measure);
  return column != nullptr && column->more_is_better;
}

std::string MeaningOf(const std::string& measure) {
  if (measure == "bad1") {
    return "share of pixels with ground truth that are off by more than 1 px or have no disparity";
  }
  if (measure.ends_with("_ms")) {
    return "time a frame, mean of its log; depends on what else the machine did";
  }
  const QualityColumn* column = FindQualityColumn(measure);
  return column == nullptr ? "" : std::string(column->meaning);
}

// Times are not coloured: they depend on what else the machines did.
std::string DifferenceCell(const std::string& measure, double a, double b) {
  if (std::isnan(b - a)) return "<td>-</td>";
  if (std::abs(b - a) < 1e-9) return "<td class=\"none\">0</td>";
  const char* kind = measure.ends_with("_ms")               ? ""
                     : MoreIsBetter(measure) == (b - a > 0) ? "better"
                                                            : "worse";
  return fmt::format("<td class=\"{}\">{:+.3g}</td>", kind, b - a);
}

// The rows of a log.
struct LogLine {
  int log;
  size_t first;
  size_t last;
  double key;  // logs are sorted by it, the largest first
};

// @param key  by row; may be empty.
std::vector<LogLine> LogLinesOf(const FrameTable& frames, const std::vector<float>& key,
                                double sign) {
  std::vector<LogLine> lines;
  for (size_t i = 0; i < frames.size();) {
    size_t end = i;
    while (end < frames.size() && frames.LogOf(end) == frames.LogOf(i)) ++end;
    const double mean = MeanOf(key, i, end);
    lines.push_back({frames.LogOf(i), i, end, std::isnan(mean) ? 0 : sign * mean});
    i = end;
  }
  std::ranges::stable_sort(lines, std::greater(), &LogLine::key);
  return lines;
}

std::string StripCell(const std::vector<float>& strip, const LogLine& line, double top) {
  if (strip.empty()) return "<td></td>";
  const auto at = [&](size_t i) { return strip.begin() + static_cast<std::ptrdiff_t>(i); };
  return "<td class=\"strip\">" + StripSvg({at(line.first), at(line.last)}, top) + "</td>";
}

}  // namespace

std::vector<std::string> ShownMeasures(const Manifest& manifest) {
  std::vector<std::string> measures = MeasureColumns();
  measures.emplace_back("bad1");
  for (const std::string& stage : manifest.stage()) measures.push_back(stage + "_ms");
  return measures;
}

std::string MeansHtml(const Manifest& manifest, const FrameTable& frames) {
  const bool has_b = manifest.variant_size() > 1;
  std::string html = "<h2>What changed</h2>\n<table><tr><th>mean over all frames</th><th>A</th>";
  if (has_b) html += "<th>B</th><th>B &minus; A</th>";
  html += "<th></th></tr>\n";
  for (const std::string& measure : ShownMeasures(manifest)) {
    const double a = MeanOf(frames.Column("a_" + measure));
    const double b = MeanOf(frames.Column("b_" + measure));
    if (std::isnan(a) && std::isnan(b)) continue;
    html += fmt::format("<tr><td>{}</td><td>{}</td>", measure, Number(a));
    if (has_b) html += fmt::format("<td>{}</td>", Number(b)) + DifferenceCell(measure, a, b);
    html += fmt::format("<td style=\"text-align:left;color:#666\">{}</td></tr>\n",
                        EscapedHtml(MeaningOf(measure)));
  }
  html += "</table>\n";
  const auto has_confidence = [&](const char* column) {
    return !std::isnan(MeanOf(frames.Column(column)));
  };
  if (has_b && has_confidence("a_confidence") != has_confidence("b_confidence")) {
    html +=
        "<p class=\"bad\">Only one of the two gives a confidence, which is a factor of the "
        "score: their scores do not compare.</p>\n";
  }
  return html;
}

std::string LogsHtml(const Manifest& manifest, const FrameTable& frames) {
  const bool has_b = manifest.variant_size() > 1;
  const std::vector<float> score_a = frames.Column("a_score");
  const std::vector<float> score = has_b ? frames.Column("b_score") : score_a;
  std::vector<float> strip = has_b ? frames.Column("moved") : score;
  const std::vector<LogLine> lines = LogLinesOf(frames, strip, has_b ? 1 : -1);
  const std::vector<float> moved = has_b ? strip : std::vector<float>();
  if (!has_b) std::ranges::transform(strip, strip.begin(), [](float x) { return 1 - x; });
  double top = 1e-6;
  for (const float value : strip) top = std::isnan(value) ? top : std::max(top, double{value});

  std::string html = "<h2>Where</h2>\n";
  if (has_b) html += "<p>Moved: share of the pixels that move by more than 1 px.</p>\n";
  html += "<table><tr><th>log</th><th>frames</th>";
  if (has_b) html += "<th>moved</th><th>score A</th>";
  html += fmt::format("<th>score {}</th><th>{} along the log</th></tr>\n", has_b ? "B" : "A",
                      has_b ? "moved" : "1 &minus; score");
  for (size_t i = 0; i < std::min(lines.size(), kShownLogs); ++i) {
    const auto [log, first, last, key] = lines[i];
    html += fmt::format("<tr><td>{}</td><td>{}</td>", EscapedHtml(manifest.log(log).name()),
                        last - first);
    if (has_b) {
      html += fmt::format("<td>{}</td><td>{}</td>", Number(MeanOf(moved, first, last)),
                          Number(MeanOf(score_a, first, last)));
    }
    html += fmt::format("<td>{}</td>", Number(MeanOf(score, first, last))) +
            StripCell(strip, lines[i], top) + "</tr>\n";
  }
  html += "</table>\n";
  if (lines.size() > kShownLogs) {
    html += fmt::format("<p>{} more logs are in frames.csv.</p>\n", lines.size() - kShownLogs);
  }
  return html;
}

}  // namespace sprout::batch
