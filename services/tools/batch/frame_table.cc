#include "services/tools/batch/frame_table.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>

#include "common/core/number_text.h"
#include "common/core/output_file.h"
#include "common/core/signal_watcher.h"
#include "common/logfile/log_error.h"
#include "services/tools/batch/log_task.h"
#include "services/tools/batch/manifest.h"
#include "services/tools/batch/measures.h"

namespace sprout::batch {
namespace {

Cell ParseCell(const std::filesystem::path& path, std::string_view text) {
  const Cell value = ParseNumber<double>(text);
  if (!value && !text.empty()) {
    throw LogError(path, "'" + std::string(text) + "' is no finite number");
  }
  return value;
}

// Whole numbers without an exponent: utime and seq are exact up to 2^53.
std::string CellText(double value) {
  constexpr double kExact = int64_t{1} << 53;
  const bool is_whole = value == std::floor(value) && std::abs(value) < kExact;
  return is_whole ? fmt::format("{:.0f}", value) : fmt::format("{:.6g}", value);
}

namespace fs = std::filesystem;
using Cells = std::vector<Cell>;

// Columns after kFrameColumns: those of A, of B, and of their comparison; any may be empty.
using ColumnGroups = std::array<std::vector<std::string>, 3>;

ColumnGroups GroupsOf(const Manifest& manifest) {
  ColumnGroups groups;
  for (int i = 0; i < manifest.variant_size(); ++i) {
    auto& group = groups[static_cast<size_t>(i)];
    for (const std::string& name : MeasureColumns()) group.push_back(VariantName(i) + "_" + name);
    for (const std::string& stage : manifest.stage()) {
      group.push_back(VariantName(i) + "_" + stage + "_ms");
    }
  }
  if (Compares(manifest)) groups[2] = ComparisonColumns();
  return groups;
}

// Mean wall time a frame of each stage, ms.
Cells TimesOf(const fs::path& result, const Manifest& manifest) {
  Cells times;
  const StageRuns runs = ReadStageRuns(result, manifest);
  for (const StageRun& run : runs.run()) {
    const auto frames = static_cast<double>(run.frames_out());
    times.push_back(frames > 0 ? Cell(1000 * run.seconds() / frames) : std::nullopt);
  }
  return times;
}

// The rows of one log, joined from the tables of its results.
class LogRows {
 public:
  LogRows(const BatchFolder& folder, const Manifest& manifest, int log) {
    for (int i = 0; i < manifest.variant_size(); ++i) {
      const fs::path result = folder.result(manifest, log, i);
      const Cells times = TimesOf(result, manifest);
      for (const Cells& row : ReadTable(result / kMeasures, MeasureColumns()).rows) {
        Cells cells(row.begin() + kFrameCells, row.end());
        cells.insert(cells.end(), times.begin(), times.end());
        Put(row, static_cast<size_t>(i), std::move(cells));
      }
    }
    if (!Compares(manifest)) return;
    const fs::path changes = folder.comparison(manifest, log) / kChanges;
    for (const Cells& row : ReadTable(changes, ComparisonColumns()).rows) {
      Put(row, 2, Cells(row.begin() + kFrameCells, row.end()));
    }
  }

  void AppendTo(std::vector<Cells>& rows, const ColumnGroups& groups) const {
    for (const Key& key : order_) {
      Cells row = rows_.at(key).id;
      for (size_t i = 0; i < groups.size(); ++i) {
        Cells cells = rows_.at(key).groups[i];
        cells.resize(groups[i].size());
        row.insert(row.end(), cells.begin(), cells.end());
      }
      rows.push_back(std::move(row));
    }
  }

 private:
  using Key = std::pair<double, double>;  // utime, seq

  struct Row {
    Cells id;  // kFrameColumns
    std::array<Cells, 3> groups;
  };

  void Put(const Cells& row, size_t group, Cells cells) {
    const Key key(*row[1], *row[0]);
    const auto [place, is_new] = rows_.try_emplace(key);
    if (is_new) {
      place->second.id.assign(row.begin(), row.begin() + kFrameCells);
      order_.push_back(key);
    }
    place->second.groups[group] = std::move(cells);
  }

  std::map<Key, Row> rows_;
  std::vector<Key> order_;
};

}  // namespace

Table Table::Of(const std::vector<std::string>& columns) {
  Table table{.columns = {std::begin(kFrameColumns), std::end(kFrameColumns)}, .rows = {}};
  table.columns.insert(table.columns.end(), columns.begin(), columns.end());
  return table;
}

std::string RowText(const std::vector<Cell>& row) {
  std::string line;
  for (size_t i = 0; i < row.size(); ++i) {
    if (i > 0) line += ',';
    if (row[i]) line += CellText(*row[i]);
  }
  return line + "\n";
}

void WriteTable(const std::filesystem::path& path, const Table& table) {
  std::string text = fmt::format("{}\n", fmt::join(table.columns, ","));
  for (const auto& row : table.rows) text += RowText(row);
  WriteText(path, text);
}

Table ReadTable(const std::filesystem::path& path, const std::vector<std::string>& columns) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) throw LogError(path, "cannot be read");
  Table table = Table::Of(columns);
  if (!std::ranges::equal(SplitAt(',', line), table.columns)) {
    throw LogError(path, "has other columns");
  }
  while (std::getline(file, line)) {
    std::vector<Cell>& row = table.rows.emplace_back();
    for (const std::string_view cell : SplitAt(',', line)) row.push_back(ParseCell(path, cell));
    if (row.size() != table.columns.size()) throw LogError(path, "a row has missing cells");
    if (!row[0] || !row[1]) throw LogError(path, "a row has no seq or utime");
  }
  if (file.bad()) throw LogError(path, "cannot be read");
  return table;
}

FrameTable::FrameTable(const BatchFolder& folder, const Manifest& manifest,
                       const BatchState& state) {
  const ColumnGroups groups = GroupsOf(manifest);
  table_ = Table::Of({});
  for (const auto& group : groups) {
    table_.columns.insert(table_.columns.end(), group.begin(), group.end());
  }
  for (int log = 0; log < manifest.log_size(); ++log) {
    if (!state.done[static_cast<size_t>(log)]) continue;
    Interrupt::Check();
    LogRows(folder, manifest, log).AppendTo(table_.rows, groups);
    logs_.resize(table_.rows.size(), log);
  }
}

std::vector<float> FrameTable::Column(const std::string& name) const {
  const auto found = std::ranges::find(table_.columns, name);
  if (found == table_.columns.end()) return {};
  const auto at = static_cast<size_t>(found - table_.columns.begin());
  std::vector<float> column;
  column.reserve(size());
  for (const Cells& row : table_.rows) {
    column.push_back(row[at] ? static_cast<float>(*row[at])
                             : std::numeric_limits<float>::quiet_NaN());
  }
  return column;
}

void WriteFrameTable(const BatchFolder& folder, const Manifest& manifest,
                     const FrameTable& frames) {
  OutputFile file(folder.table());
  file.Write("log,seq,utime");
  const auto& columns = frames.table().columns;
  for (size_t i = kFrameCells; i < columns.size(); ++i) file.Write("," + columns[i]);
  file.Write("\n");
  for (size_t i = 0; i < frames.size(); ++i) {
    Cells row = frames.table().rows[i];
    row.erase(row.begin() + 2);  // left_at
    file.Write(manifest.log(frames.LogOf(i)).name() + "," + RowText(row));
  }
  if (!file.Commit()) {
    throw LogError(folder.table(), "cannot be written (" + file.failure() + ")");
  }
}

double MeanOf(const std::vector<float>& values, size_t first, size_t last) {
  double sum = 0;
  int64_t count = 0;
  for (size_t i = first; i < std::min(last, values.size()); ++i) {
    if (std::isnan(values[i])) continue;
    sum += values[i];
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace sprout::batch
