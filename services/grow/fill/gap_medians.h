#pragma once

#include <array>
#include <cstdint>

#include "common/core/disparity_image.h"

namespace sprout::grow {

/// Pixels of a row that are filled at once.
inline constexpr int kFillColumns = 32;
using FilledPixels = std::array<int16_t, kFillColumns>;

/// The pixels of row v from column u on, gaps filled with the median of the valid counts in their
/// 5×5 windows (the lower one of two in the middle; windows end at the map's border). Gaps without
/// a valid count around them stay gaps, as do columns beyond the map.
///
/// Sorts as many windows at once as a register has lanes (Batcher's odd-even merge sort), if there
/// is a gap among them; the same result on every CPU. O(1); takes no memory.
void FillPixels(const DisparityImage& map, int v, int u, FilledPixels& filled);

}  // namespace sprout::grow
