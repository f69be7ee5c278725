#pragma once

#include <span>

#include "services/refine/range/range_nodes.h"
#include "services/refine/range/sensor_place.h"

namespace sprout::refine {

/// Whether the images show the places at disparities that are off from the range sensor's by the
/// same px at all depths of a row, and by others in other rows. So it is where the pair is at
/// fault: its rows are exposed one after the other, a part of a frame hangs. A range sensor errs by
/// metres, or by a part of the depth, whatever the row.
/// @param offsets_px   of the nodes, by which they are off.
/// @param infinity_px  disparity of infinity.
/// @returns false where that is below a quarter of a px, or each row shows one depth, so that it
///          may be either; with fewer than 250 nodes.
/// O(n log n). No I/O; thread-safe; the same on every machine.
bool ShiftsRows(const RangeNodes& nodes, std::span<const double> offsets_px, double infinity_px);

/// The same of matches of stereo that knows nothing of the points, each beside a corrected one.
/// O(points + matches log matches).
bool ShiftsRows(const PlacedPoints& points, std::span<const Seed> matches);

}  // namespace sprout::refine
