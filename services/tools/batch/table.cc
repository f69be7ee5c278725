#include "services/tools/batch/table.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <sstream>

#include "common/core/read_text.h"
#include "common/logfile/log_error.h"
#include "services/tools/batch/manifest.h"

namespace sprout::batch {
namespace {

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

Cell ParseCell(const std::filesystem::path& path, const std::string& text) {
  if (text.empty()) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw LogError(path, "'" + text + "' is no finite number");
  }
  return value;
}

// Whole numbers without an exponent: utime and seq are exact up to 2^53.
std::string CellText(double value) {
  constexpr double kExact = int64_t{1} << 53;
  const bool is_whole = value == std::floor(value) && std::abs(value) < kExact;
  return is_whole ? fmt::format("{:.0f}", value) : fmt::format("{:.6g}", value);
}

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
  std::istringstream file(ReadText(path, kMaxListBytes).value_or(""));
  std::string line;
  if (!std::getline(file, line)) throw LogError(path, "cannot be read");
  Table table = Table::Of(columns);
  if (Split(line) != table.columns) throw LogError(path, "has other columns");
  while (std::getline(file, line)) {
    std::vector<Cell>& row = table.rows.emplace_back();
    for (const std::string& cell : Split(line)) row.push_back(ParseCell(path, cell));
    if (row.size() != table.columns.size()) throw LogError(path, "a row has missing cells");
    if (!row[0] || !row[1]) throw LogError(path, "a row has no seq or utime");
  }
  return table;
}

}  // namespace sprout::batch
