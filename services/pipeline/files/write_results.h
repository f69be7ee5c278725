#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/frame.h"
#include "common/core/result.h"
#include "services/pipeline/pipeline.h"

namespace sprout {

/// What can be written of a frame. Its files:
/// * disparity.pfm (px, +inf: none), disparity.png (16 bit, 1/32 px, 0: none or negative);
/// * depth.pfm (m, NaN: none), depth.png (16 bit, mm, 0: none or above kMaxPngDepthM);
/// * confidence.png (8 bit), where there is a confidence;
/// * depth_sigma.pfm (m, NaN: no depth, +inf: not known), the same, only of single maps;
/// * fused.pfm, fused.png, fused_confidence.png, of a pipeline with memory;
/// * left.png, cloud.ply, mesh.ply, overview.png;
/// * always the calibration: camera.json, as in RectifiedPair, calib.txt in Middlebury's format.
inline constexpr std::array kOutputs = {"disparity", "depth", "confidence", "sigma",   "fused",
                                        "left",      "cloud", "mesh",       "overview"};

/// Every file that WriteResults() may write.
inline constexpr std::string_view kResultNames[] = {
    "disparity.pfm", "disparity.png", "confidence.png",       "fused.pfm",   "fused.png",
    "depth.pfm",     "depth.png",     "fused_confidence.png", "cloud.ply",   "mesh.ply",
    "overview.png",  "left.png",      "depth_sigma.pfm",      "camera.json", "calib.txt"};

/// Writes the results of a frame, several at a time, on as many threads as OpenCV has. Files of
/// these names are replaced, or removed where this frame has no such result. Depth, cloud, mesh and
/// overview are of `depth.kept`.
/// @param frame   LEFT, RIGHT, TOF and RIG.
/// @param input   which map `depth.kept` is of.
/// @param only    some of kOutputs; none: all.
/// @param folder  is created.
/// @returns path and reason of the first file, in the order above, that could not be removed or
///          written.
Result<void> WriteResults(Frame frame, const DepthFrame& depth, DepthConfig::Input input,
                          const std::vector<std::string>& only,
                          const std::filesystem::path& folder);

}  // namespace sprout
