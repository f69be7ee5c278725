#ifndef SPROUT_SERVICES_TOOLS_BATCH_MEASURES_H_
#define SPROUT_SERVICES_TOOLS_BATCH_MEASURES_H_

#include <filesystem>
#include <string>
#include <vector>

#include "services/tools/batch/frame_lookup.h"
#include "services/tools/batch/table.h"

namespace sprout::batch {

/// Columns behind kFrameColumns in the tables of MeasureFrames() and CompareFrames().
std::vector<std::string> MeasureColumns();
std::vector<std::string> ComparisonColumns();

/// The parts that QualityOf() looks at.
const PartSet& MeasuredParts();

/// A row for each answered frame with the figures of QualityOf(), of the fused map where that is
/// the answer.
/// @param frames   has the input, and the answers of all stages.
/// @param answer   the part that the last stage always answers.
/// @param measure  false: the figures are empty, and no image is read.
Table MeasureFrames(FrameLookup& frames, Part answer, bool measure);

/// A row for each frame that A or B answered: changed, moved, mean_change_px, max_change_px,
/// appeared, vanished, and with a truth a_bad1 and b_bad1.
/// @param b      null: A alone.
/// @param map    the part to compare: kDisparity or kFused.
/// @param truth  folder with NNNNNN_disparity.pfm as `sprout-log export --pfm` writes them; empty:
///               none.
Table CompareFrames(FrameLookup& a, FrameLookup* b, Part map, const std::filesystem::path& truth);

}  // namespace sprout::batch

#endif  // SPROUT_SERVICES_TOOLS_BATCH_MEASURES_H_
