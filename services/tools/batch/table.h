#ifndef SPROUT_SERVICES_TOOLS_BATCH_TABLE_H_
#define SPROUT_SERVICES_TOOLS_BATCH_TABLE_H_

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

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

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_TABLE_H_
