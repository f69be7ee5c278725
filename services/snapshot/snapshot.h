#ifndef SPROUT_SERVICES_SNAPSHOT_SNAPSHOT_H_
#define SPROUT_SERVICES_SNAPSHOT_SNAPSHOT_H_

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/core/frame.h"
#include "common/core/result.h"
#include "common/core/stage_status.h"
#include "services/datasets/dataset.h"

namespace sprout::snapshot {

/// Writes a frame for people to look at: left, tof, seeds_raw, seeds, prior, prior_sigma,
/// disparity (as grown), disparity_filled, confidence and cloud (seen from the side) as .png with
/// one common scale of disparity and depth, overview.png of four of them, disparity.pfm (px), and
/// cloud.ply and mesh.ply (m, coloured) of the filled map. With a truth also errors.png. Pictures
/// of parts that the frame does not have are left out, see MissingParts().
/// @param frame   with all parts but `unfilled` and `confidence`, which are optional.
/// @param truth   of the frame's scene; may be empty.
/// @param folder  exists already.
/// @returns the first error: an image that is not of the calibrated size, or a file with its path.
Result<void> WriteFrameFiles(const Frame& frame, const datasets::GroundTruth& truth,
                             const std::filesystem::path& folder);

/// A line for each optional part that is not there: what is not shown and how to get it.
std::vector<std::string> MissingParts(const Frame& frame);

/// The table of a run: times and counts of each stage and how much of the left image ToF seeds
/// cover in its newest frame, seeds dropped by cause, and density and
/// share of correct non-occluded pixels (≤ 1 px) of prior, growth and filled map.
/// @param truth  of the frame's scene; without a left map the shares are left out.
/// @returns text of several lines; an error when truth and frame differ in size.
Result<std::string> ReportText(const Frame& frame,
                               const std::map<std::string, StageStatus>& statuses,
                               const datasets::GroundTruth& truth);

}  // namespace sprout::snapshot

#endif  // SPROUT_SERVICES_SNAPSHOT_SNAPSHOT_H_
