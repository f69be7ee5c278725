#ifndef SPROUT_SERVICES_PIPELINE_FILES_WRITE_RESULTS_H_
#define SPROUT_SERVICES_PIPELINE_FILES_WRITE_RESULTS_H_

#include <filesystem>
#include <string_view>

#include "common/core/frame.h"
#include "common/core/result.h"
#include "common/picture/write_image.h"
#include "services/pipeline/pipeline.h"

namespace sprout {

/// Every file that WriteResults() may write.
inline constexpr std::string_view kResultNames[] = {
    "disparity.pfm", "disparity.png", "confidence.png",       "fused.pfm",      "fused.png",
    "depth.pfm",     "depth.png",     "fused_confidence.png", "cloud.ply",      "mesh.ply",
    "overview.png",  "left.png",      "camera.json",          "depth_sigma.pfm"};

/// Writes the results of a frame: disparity.pfm (px, +inf: none) and disparity.png (16 bit, 1/32
/// px, 0: none or negative), depth.pfm (m, NaN: none) and depth.png (16 bit, mm, 0: none or more
/// than kMaxPngDepthM), confidence.png (8 bit) and depth_sigma.pfm (m, +inf: not known, only of
/// single maps) where there is a confidence, left.png (the image that the maps belong to),
/// camera.json (its calibration, as in RectifiedPair), cloud.ply, mesh.ply, overview.png; of a
/// pipeline with memory also fused.pfm, fused.png and fused_confidence.png. Files of these names
/// are replaced.
/// @param frame   LEFT, RIGHT, TOF and RIG.
/// @param input   which map `depth.depth_m` is of; cloud, mesh and overview are of the same.
/// @param folder  is created.
/// @returns path and reason of the first file that could not be written.
Result<void> WriteResults(Frame frame, const DepthFrame& depth, DepthConfig::Input input,
                          const std::filesystem::path& folder);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PIPELINE_FILES_WRITE_RESULTS_H_
