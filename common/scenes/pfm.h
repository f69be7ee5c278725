#ifndef SPROUT_COMMON_SCENES_PFM_H_
#define SPROUT_COMMON_SCENES_PFM_H_

#include <filesystem>
#include <opencv2/core.hpp>

namespace sprout::scenes {

/// Reads a one-channel PFM file ("Pf"), top row first, samples as stored.
///
/// cv::imread divides the samples by the scale in the header. Middlebury writes disparities in px
/// together with a scale that is meant for viewers (0.003922 in the full-size files), so the
/// division would be wrong; of the scale only the sign, the byte order, is used.
///
/// @throws ConfigError naming the file: unreadable, another format, truncated.
cv::Mat1f ReadPfm(const std::filesystem::path& path);

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_PFM_H_
