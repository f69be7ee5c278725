#ifndef SPROUT_SERVICES_BATCH_TABLES_H_
#define SPROUT_SERVICES_BATCH_TABLES_H_

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/core/disparity_image.h"
#include "services/batch/frame_lookup.h"

namespace sprout::batch {

/// A small table: the columns' names, then a row of numbers each, with gaps.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<std::optional<double>>> rows;

  /// Place of a column; nothing when there is none.
  std::optional<size_t> Find(const std::string& column) const;
};

/// Numbers as short as they can be read back. @throws LogError.
void WriteTable(const std::filesystem::path& path, const Table& table);
std::string TableHead(const Table& table);
std::string TableRow(const std::vector<std::optional<double>>& row);

/// @throws LogError when it is no table of numbers.
Table ReadTable(const std::filesystem::path& path);

/// Columns behind seq and utime in the tables of MeasureFrames() and CompareFrames().
std::vector<std::string> MeasureColumns();
std::vector<std::string> ComparisonColumns();

/// Whether MeasureFrames() looks at any of these parts.
bool IsMeasured(const PartSet& parts, Part answer);

/// A row for each answered frame: seq, utime and what QualityOf() sees.
/// @param frames  has the input, and the answers of all stages.
/// @param answer  what the last stage always answers.
Table MeasureFrames(FrameLookup& frames, Part answer);

/// What differs between two maps. Shares are of all pixels.
struct MapChange {
  double changed = 0;   ///< has another disparity, or one in one map only
  double moved = 0;     ///< the same by more than 1 px, or in one map only
  double mean_px = 0;   ///< mean |difference| where both have a disparity
  double max_px = 0;    ///< largest
  double appeared = 0;  ///< only B has one
  double vanished = 0;  ///< only A has one
};

/// @pre both have the same size, not empty. O(pixels).
MapChange ChangeOf(const DisparityImage& a, const DisparityImage& b);

/// Share of the pixels with a true disparity where the map is off by more than 1 px or has none;
/// nothing when there is no true one or the sizes differ. O(pixels).
std::optional<double> BadShare(const DisparityImage& map, const cv::Mat1f& truth_px);

/// A row for each frame that A or B answered: seq, utime, changed, moved, mean_change_px,
/// max_change_px, appeared, vanished, and with a truth a_bad1 and b_bad1.
/// @param truth  folder with NNNNNN_disparity.pfm as `sprout-log export --pfm` writes them; empty:
///               none.
Table CompareFrames(FrameLookup& a, FrameLookup* b, const std::filesystem::path& truth);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_BATCH_TABLES_H_
