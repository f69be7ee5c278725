#include <fmt/core.h>

#include <algorithm>
#include <map>

#include "common/picture/html.h"
#include "services/tools/batch/log_try.h"
#include "services/tools/batch/report.h"
#include "services/tools/batch/stage_runs.h"

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

// A log without complete frames is bad, too.
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

}  // namespace sprout::batch
