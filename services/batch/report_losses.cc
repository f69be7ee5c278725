#include "services/batch/report_losses.h"

#include <fmt/core.h>

#include <algorithm>

#include "common/picture/html.h"
#include "services/batch/shard_try.h"
#include "services/batch/text_file.h"

namespace sprout::batch {
namespace {

constexpr size_t kShownFailures = 20;

// A column of the table; those of variants come once for each.
struct Column {
  const char* head;
  int64_t Losses::*count;
  bool is_bad = true;
};
struct VariantColumn {
  const char* head;
  int64_t Losses::OfVariant::*count;
};

constexpr Column kShardColumns[] = {{"shards", &Losses::shards, false},
                                    {"tried again", &Losses::retried},
                                    {"failed", &Losses::failed},
                                    {"not tried", &Losses::untried},
                                    {"complete frames", &Losses::frames, false}};
constexpr VariantColumn kVariantColumns[] = {
    {"without answer", &Losses::OfVariant::unanswered},
    {"empty map", &Losses::OfVariant::empty},
    {"refused messages", &Losses::OfVariant::refused},
};
constexpr Column kInputColumns[] = {{"incomplete frames", &Losses::incomplete},
                                    {"numbers left out", &Losses::left_out},
                                    {"unreadable messages", &Losses::undecodable},
                                    {"damaged bytes", &Losses::damaged_bytes}};

constexpr char kLegend[] =
    "<p><b>Tried again</b>: the shard is done, but a try before failed or was killed. <b>Without "
    "answer</b>: all messages of the frame are there, a stage failed on it or refused one. "
    "<b>Empty map</b>: too few seeds. <b>Incomplete</b>: a message of the frame never came. "
    "<b>Left out</b>: no message has this frame number. Columns A and B count only shards that are "
    "done.</p>\n";

// A log without shards or frames is bad, too.
std::string CountCell(int64_t count, bool is_bad) {
  const char* kind = (count > 0) == is_bad ? " class=\"bad\"" : count == 0 ? " class=\"none\"" : "";
  return fmt::format("<td{}>{}</td>", kind, count);
}

std::string Head(const BatchHead& head) {
  std::string html = "<tr><th>log</th>";
  for (const Column& column : kShardColumns) html += fmt::format("<th>{}</th>", column.head);
  for (const Variant& variant : head.variants) {
    for (const VariantColumn& column : kVariantColumns) {
      html += fmt::format("<th>{}{}</th>", column.head,
                          head.variants.size() == 1 ? ""
                          : variant.name == "a"     ? " A"
                                                    : " B");
    }
  }
  for (const Column& column : kInputColumns) html += fmt::format("<th>{}</th>", column.head);
  return html + "</tr>\n";
}

std::string Row(const std::string& name, const Losses& losses) {
  std::string html = "<tr><td>" + name + "</td>";
  for (const Column& column : kShardColumns) html += CountCell(losses.*column.count, column.is_bad);
  for (const Losses::OfVariant& variant : losses.variants) {
    for (const VariantColumn& column : kVariantColumns)
      html += CountCell(variant.*column.count, true);
  }
  for (const Column& column : kInputColumns) html += CountCell(losses.*column.count, column.is_bad);
  return html + "</tr>\n";
}

// Shards that failed first, then those that were tried again.
std::string Failures(const BatchFolder& folder, const Manifest& manifest, const BatchState& state) {
  struct Failure {
    size_t shard;
    int64_t tries;
  };
  std::vector<Failure> failures;
  for (const auto& [shard, tries] : FailedTries(folder)) {
    if (shard < state.done.size()) failures.push_back({shard, tries});
  }
  std::stable_partition(failures.begin(), failures.end(),
                        [&](const Failure& failure) { return !state.done[failure.shard]; });
  if (failures.empty()) return "";
  std::string html = "<table><tr><th>shard</th><th></th><th></th></tr>\n";
  for (size_t i = 0; i < std::min(failures.size(), kShownFailures); ++i) {
    const auto [number, tries] = failures[i];
    const Shard& shard = manifest.shards[number];
    const auto path = TryPath(folder, number, tries);
    html += fmt::format(
        "<tr><td>{}: {}, frames {}:{}</td><td>{} after {} failed {}</td><td class=\"strip\"><a "
        "href=\"failed/{}\">{}</a></td></tr>\n",
        number, EscapedHtml(manifest.logs[static_cast<size_t>(shard.log)].name), shard.first_seq,
        shard.last_seq, state.done[number] ? "done" : "missing", tries,
        tries == 1 ? "try" : "tries", path.filename().string(), EscapedHtml(FirstLineOf(path)));
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
  const std::vector<Losses> logs = LossesOf(folder, manifest, state);
  Losses all;
  std::string rows;
  size_t with_losses = 0;
  for (size_t i = 0; i < logs.size(); ++i) {
    all.Add(logs[i]);
    if (!logs[i].Any() || ++with_losses > kShownLogs) continue;
    rows += Row(EscapedHtml(manifest.logs[i].name), logs[i]);
  }
  std::string html = "<h2>What failed or is missing</h2>\n";
  html += "<table>" + Head(manifest.head) +
          Row(fmt::format("all {} log{}", logs.size(), logs.size() == 1 ? "" : "s"), all) + rows +
          "</table>\n";
  html += with_losses == 0 ? "<p>Nothing, in any log.</p>\n" : kLegend;
  if (with_losses > kShownLogs) {
    html += fmt::format("<p>{} more logs have losses.</p>\n", with_losses - kShownLogs);
  }
  return html + Failures(folder, manifest, state);
}

}  // namespace sprout::batch
