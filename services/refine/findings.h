#pragma once

#include <optional>
#include <string>

#include "common/core/seed.h"
#include "services/refine/alignment/scan_alignment.h"
#include "services/refine/alignment/tof_alignment.h"
#include "services/refine/range/contradiction.h"
#include "services/refine/range/range_bias.h"
#include "services/refine/range/sensor_place.h"
#include "services/refine/surface/fattened_edges.h"
#include "services/refine/surface/smoothed_edges.h"

namespace sprout::refine {

/// What refine found in a frame of its range sensor and its pair, beside the seeds.
struct RefineFindings {
  /// How far off the points were projected, with align_tof; if IsOff(), they were moved before all
  /// rules. Not sure when no offset was searched.
  TofOffset tof_offset;
  ScanMove scan_move;      ///< the same for a lidar's scan; its points were moved if is_off
  RangeError range_error;  ///< how far the sensor is off, with range_bias
  /// Where stereo shows the points, if they were doubtful; no point is believed if is_displaced.
  SensorPlace sensor_place;
  Contradiction contradiction;  ///< points that stereo contradicts; they were dropped
  Smoothing smoothing;          ///< a smoothed range image: points beside its edges were dropped
  Fattening fattening;  ///< near surfaces reached beyond their edges: points there were dropped
  /// Most points that are neither outside nor dark were loose: then all are.
  bool are_noise = false;
  size_t unanswered_cells = 0;  ///< of stereo, see StereoSeedFinder
};

/// One line for people: why a frame's answer is degenerate, since it has no seeds, or since its
/// range points or its images are not believed. Several reasons are joined by "; "; empty when
/// there is none.
/// @param seeds  of the same frame.
/// @param stereo_seeds  whether stereo was asked for seeds.
std::string DegenerateText(const RefineFindings& found, const SeedSet& seeds, bool stereo_seeds);

/// One line for people: what was found of the range sensor in a frame that is answered, such as by
/// how much its points were moved. Empty for a sensor that is right; nothing when the images do not
/// show whether it is.
std::optional<std::string> FindingText(const RefineFindings& found);

}  // namespace sprout::refine
