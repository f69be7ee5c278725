#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "common/measure/frame_quality.h"
#include "common/picture/html.h"
#include "services/tools/batch/log_task.h"
#include "services/tools/batch/measures.h"
#include "services/tools/batch/report.h"
#include "services/tools/batch/result_folder.h"

namespace sprout::batch {
namespace {

constexpr size_t kShownFailures = 20;

// A column of the table, how a log counts in it, and whether more than 0 is bad.
struct Column {
  std::string head;
  int64_t count = 0;
  bool is_bad = true;
};

constexpr char kLegend[] =
    "<p><b>Tried again</b>: the log is done, but a try before failed or was killed. <b>Without "
    "answer</b>: all messages of the frame are there, a stage failed on it or refused one. "
    "<b>Empty map</b>: too few seeds. <b>Refused messages</b>: by the stage that refused most. "
    "<b>Incomplete</b>: a message of the frame never came. <b>Left out</b>: no message has this "
    "frame number. The columns behind them count only logs that are done.</p>\n";

// Counts of a variant: each message goes to several stages, and each refuses it.
void AddVariant(const StageRuns& runs, const std::string& of, std::vector<Column>& columns) {
  const StageRun& first = runs.run(0);
  const StageRun& last = *runs.run().rbegin();
  int64_t refused = 0;
  for (const StageRun& run : runs.run()) refused = std::max(refused, run.bad_messages());
  columns.push_back({"without answer" + of, first.frames_in() - last.frames_out()});
  columns.push_back({"empty map" + of, last.degenerate()});
  columns.push_back({"refused messages" + of, refused});
}

std::vector<Column> LossesOf(const BatchFolder& folder, const Manifest& manifest, int log,
                             bool is_done, bool is_tried) {
  std::vector<StageRuns> runs(static_cast<size_t>(manifest.variant_size()));
  for (size_t i = 0; i < runs.size(); ++i) {
    if (is_done) {
      runs[i] = ReadStageRuns(folder.result(manifest, log, static_cast<int>(i)), manifest);
    } else {
      runs[i].add_run();
    }
  }
  const StageRun& input = runs[0].run(0);  // every variant has the same
  std::vector<Column> columns = {{"logs", 1, false},
                                 {"tried again", is_done && is_tried},
                                 {"failed", !is_done && is_tried},
                                 {"not tried", !is_done && !is_tried},
                                 {"complete frames", input.frames_in(), false}};
  for (size_t i = 0; i < runs.size(); ++i) {
    AddVariant(runs[i], runs.size() == 1 ? "" : i == 0 ? " A" : " B", columns);
  }
  columns.push_back({"incomplete frames", input.incomplete()});
  columns.push_back({"numbers left out", input.left_out()});
  columns.push_back({"damaged bytes", input.damaged_bytes()});
  return columns;
}

// Of most columns more than 0 is bad; of complete frames 0 is.
bool IsBad(const Column& column) { return (column.count > 0) == column.is_bad; }

std::string RowHtml(const std::string& name, const std::vector<Column>& columns) {
  std::string html = "<tr><td>" + name + "</td>";
  for (const Column& column : columns) {
    const char* kind = IsBad(column)       ? " class=\"bad\""
                       : column.count == 0 ? " class=\"none\""
                                           : "";
    html += fmt::format("<td{}>{}</td>", kind, column.count);
  }
  return html + "</tr>\n";
}

// Logs that failed first, then those that were tried again.
std::string FailuresHtml(const BatchFolder& folder, const Manifest& manifest,
                         const BatchState& state, const std::map<int, int>& tries) {
  std::vector<std::pair<int, int>> failures;  // log, tries
  for (const auto& [log, count] : tries) {
    if (log >= 0 && log < manifest.log_size()) failures.emplace_back(log, count);
  }
  std::ranges::stable_partition(failures, [&](const auto& failure) {
    return !state.done[static_cast<size_t>(failure.first)];
  });
  if (failures.empty()) return "";
  std::string html = "<table><tr><th>log</th><th></th><th></th></tr>\n";
  for (size_t i = 0; i < std::min(failures.size(), kShownFailures); ++i) {
    const auto [log, count] = failures[i];
    const auto path = TryPath(folder, log, count);
    html += fmt::format(
        "<tr><td>{}</td><td>{} after {} failed {}</td><td class=\"strip\"><a "
        "href=\"failed/{}\">{}</a></td></tr>\n",
        EscapedHtml(manifest.log(log).name()),
        state.done[static_cast<size_t>(log)] ? "done" : "missing", count,
        count == 1 ? "try" : "tries", path.filename().string(), EscapedHtml(FirstLineOf(path)));
  }
  html += "</table>\n";
  if (failures.size() > kShownFailures) {
    html += fmt::format("<p>{} more are in failed/.</p>\n", failures.size() - kShownFailures);
  }
  return html;
}

std::string Number(double value) { return std::isnan(value) ? "-" : fmt::format("{:.4g}", value); }

bool MoreIsBetter(const std::string& measure) {
  const QualityColumn* column = FindQualityColumn(measure);
  return column != nullptr && column->more_is_better;
}

std::string MeaningOf(const std::string& measure) {
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

// A log in the table of logs, by its rows of the frame table.
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

std::string LossesHtml(const BatchFolder& folder, const Manifest& manifest,
                       const BatchState& state) {
  const std::map<int, int> tries = FailedTries(folder);
  std::vector<Column> all;
  std::string rows;
  size_t with_losses = 0;
  for (int log = 0; log < manifest.log_size(); ++log) {
    const auto losses =
        LossesOf(folder, manifest, log, state.done[static_cast<size_t>(log)], tries.contains(log));
    if (all.empty()) all = losses;
    for (size_t i = 0; log > 0 && i < all.size(); ++i) all[i].count += losses[i].count;
    if (std::ranges::none_of(losses, IsBad) || ++with_losses > kShownLogs) continue;
    rows += RowHtml(EscapedHtml(manifest.log(log).name()), losses);
  }
  std::string html = "<h2>What failed or is missing</h2>\n<table><tr><th>log</th>";
  for (const Column& column : all) html += "<th>" + column.head + "</th>";
  html +=
      "</tr>\n" +
      RowHtml(fmt::format("all {} log{}", manifest.log_size(), manifest.log_size() == 1 ? "" : "s"),
              all) +
      rows + "</table>\n";
  html += with_losses == 0 ? "<p>Nothing, in any log.</p>\n" : kLegend;
  if (with_losses > kShownLogs) {
    html += fmt::format("<p>{} more logs have losses.</p>\n", with_losses - kShownLogs);
  }
  return html + FailuresHtml(folder, manifest, state, tries);
}

std::vector<std::string> ShownMeasures(const Manifest& manifest) {
  std::vector<std::string> measures = MeasureColumns();
  for (const std::string& stage : manifest.stage()) measures.push_back(stage + "_ms");
  return measures;
}

// Keeps the frames that both variants have, so that none looks better for what it left out. Where
// one has none at all, the other stays.
void KeepCommon(std::vector<float>& a, std::vector<float>& b) {
  if (std::isnan(MeanOf(a)) || std::isnan(MeanOf(b))) return;
  for (size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i]) || std::isnan(b[i])) a[i] = b[i] = NAN;
  }
}

std::string MeansHtml(const Manifest& manifest, const FrameTable& frames) {
  const bool has_b = manifest.variant_size() > 1;
  std::string html =
      fmt::format("<h2>What changed</h2>\n<table><tr><th>mean over {}</th><th>A</th>",
                  has_b ? "the frames that both have" : "all frames");
  if (has_b) html += "<th>B</th><th>B &minus; A</th>";
  html += "<th></th></tr>\n";
  for (const std::string& measure : ShownMeasures(manifest)) {
    std::vector<float> of_a = frames.Column("a_" + measure);
    std::vector<float> of_b = frames.Column("b_" + measure);
    KeepCommon(of_a, of_b);
    const double a = MeanOf(of_a);
    const double b = MeanOf(of_b);
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
  std::vector<float> score_a = frames.Column("a_score");
  std::vector<float> score = has_b ? frames.Column("b_score") : score_a;
  if (has_b) KeepCommon(score_a, score);
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
