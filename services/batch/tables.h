#ifndef SPROUT_SERVICES_BATCH_TABLES_H_
#define SPROUT_SERVICES_BATCH_TABLES_H_

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "services/batch/frame_lookup.h"

namespace sprout::batch {

/// A small table: the columns' names, then a row of numbers each, with gaps.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<std::optional<double>>> rows;

  /// Index of a column; nothing when there is none.
  std::optional<size_t> Find(const std::string& column) const;
};

/// Writes numbers with the fewest digits that read back exactly. @throws LogError.
void WriteTable(const std::filesystem::path& path, const Table& table);
std::string TableHead(const Table& table);
std::string TableRow(const std::vector<std::optional<double>>& row);

/// Columns after seq and utime in the tables of MeasureFrames() and CompareFrames().
std::vector<std::string> MeasureColumns();
std::vector<std::string> ComparisonColumns();

/// A table of frames: seq, utime, then these columns.
/// @throws LogError when the columns differ, a cell is not a finite number, or a frame has no id.
Table ReadTable(const std::filesystem::path& path, const std::vector<std::string>& columns);

/// Whether MeasureFrames() uses any of these parts.
bool IsMeasured(const PartSet& parts, Part answer);

/// A row for each answered frame: seq, utime and the figures of QualityOf(), of the fused map where
/// that is the answer.
/// @param frames  has the input, and the answers of all stages.
/// @param answer  the part that the last stage always answers.
Table MeasureFrames(FrameLookup& frames, Part answer);

/// The same rows with empty figures; reads no image.
Table ListFrames(const FrameLookup& frames, Part answer);

/// A row for each frame that A or B answered: seq, utime, changed, moved, mean_change_px,
/// max_change_px, appeared, vanished, and with a truth a_bad1 and b_bad1.
/// @param map    the part to compare: kDisparity or kFused.
/// @param truth  folder with NNNNNN_disparity.pfm as `sprout-log export --pfm` writes them; empty:
///               none.
Table CompareFrames(FrameLookup& a, FrameLookup* b, Part map, const std::filesystem::path& truth);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_TABLES_H_
