#ifndef SPROUT_COMMON_SCENES_SYNTHETIC_SOURCE_H_
#define SPROUT_COMMON_SCENES_SYNTHETIC_SOURCE_H_

#include <memory>

#include "common/core/image.h"
#include "common/scenes/dataset.h"

namespace sprout::scenes {

inline constexpr int kMinSyntheticSide = 16;        ///< px: below, objects are smaller than a pixel
inline constexpr int kMaxSyntheticSide = kMaxSide;  ///< px: a frame takes 16 bytes a pixel

/// Endless frames of SyntheticScene in colour, seen by a rectified pair whose disparities span
/// about 2 to 15 % of the image width, with exact ground truth at the pixel centres of both views
/// and a simulated ToF camera: config.tof() = grid samples the left truth, sr4000 is rendered from
/// the scene.
///
/// Frame i depends on size, config.seed() and i only: same bytes on every machine, with any
/// number of threads. O(pixels) a frame, in parallel over rows.
///
/// @param size  of the images; each side kMinSyntheticSide to kMaxSyntheticSide px.
/// @throws ConfigError when a grid of config.tof_grid_px() is larger than the image.
std::unique_ptr<Dataset> OpenSynthetic(cv::Size size, const CaptureConfig& config);

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_SYNTHETIC_SOURCE_H_
