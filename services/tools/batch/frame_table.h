#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "services/tools/batch/result_folder.h"

namespace sprout::batch {

/// A number of a table; nothing: unknown.
using Cell = std::optional<double>;

/// A table of frames: the columns' names, the first three of which are kFrameColumns, then a row of
/// numbers each.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;

  /// A table with these columns behind kFrameColumns.
  static Table Of(const std::vector<std::string>& columns);
};

/// Number and time of a frame, and the byte of the log where its left image begins.
inline constexpr const char* kFrameColumns[] = {"seq", "utime", "left_at"};
inline constexpr size_t kFrameCells = std::size(kFrameColumns);

/// Numbers as CSV with the fewest digits that read back exactly, or with 6.
std::string RowText(const std::vector<Cell>& row);

/// @throws LogError.
void WriteTable(const std::filesystem::path& path, const Table& table);

/// @param columns  behind kFrameColumns.
/// @throws LogError when the columns differ, a cell is not a finite number, or a frame has no id.
Table ReadTable(const std::filesystem::path& path, const std::vector<std::string>& columns);

/// The frames of all logs that are done: measures and times of the variants beside each other, then
/// what differs. Some 16 bytes a cell.
class FrameTable {
 public:
  /// @throws LogError, Interrupted.
  FrameTable(const BatchFolder& folder, const Manifest& manifest, const BatchState& state);

  const Table& table() const { return table_; }
  size_t size() const { return table_.rows.size(); }
  int LogOf(size_t row) const { return logs_[row]; }
  int64_t SeqOf(size_t row) const { return static_cast<int64_t>(*table_.rows[row][0]); }

  /// The values of a column, by row, NaN where unknown; empty when there is no such column.
  std::vector<float> Column(const std::string& name) const;

 private:
  Table table_;
  std::vector<int> logs_;  // by row
};

/// Writes frames.csv. @throws LogError.
void WriteFrameTable(const BatchFolder& folder, const Manifest& manifest, const FrameTable& frames);

/// Mean of the values from `first` to before `last` without NaN; NaN if there are none.
double MeanOf(const std::vector<float>& values, size_t first, size_t last);
inline double MeanOf(const std::vector<float>& values) { return MeanOf(values, 0, values.size()); }

}  // namespace sprout::batch
