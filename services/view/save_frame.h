#ifndef SPROUT_SERVICES_VIEW_SAVE_FRAME_H_
#define SPROUT_SERVICES_VIEW_SAVE_FRAME_H_

#include <filesystem>
#include <string>

#include "common/core/frame.h"
#include "common/core/result.h"

namespace sprout::view {

/// Writes a part of a frame to a file, named left.png, right.png, confidence.png, disparity.png and
/// prior.png (with a scale), disparity.pfm, prior.pfm, sigma.pfm (px; +inf: none, or not
/// known), cloud.ply (m).
/// @returns an error for another name, a missing part, or different sizes.
Result<void> SaveFrame(const Frame& frame, const std::string& what,
                       const std::filesystem::path& path);

}  // namespace sprout::view

#endif  // SPROUT_SERVICES_VIEW_SAVE_FRAME_H_
