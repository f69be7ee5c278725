#ifndef SPROUT_COMMON_PICTURE_WRITE_IMAGE_H_
#define SPROUT_COMMON_PICTURE_WRITE_IMAGE_H_

#include <filesystem>
#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"
#include "common/core/result.h"

namespace sprout {

// All write the whole file or none (see OutputFile); errors name path and reason.

/// Writes a picture (8UC1 grey or 8UC3 BGR), or a map (16UC1), as PNG.
[[nodiscard]] Result<void> WritePng(const std::filesystem::path& path, const cv::Mat& picture);

/// Writes numbers as PFM: one channel, 32-bit float, little-endian, bottom row first.
[[nodiscard]] Result<void> WritePfm(const std::filesystem::path& path, const cv::Mat1f& values);

/// Writes disparities as PFM, the format of Middlebury's ground truth: px, +inf where there is no
/// disparity.
[[nodiscard]] Result<void> WritePfm(const std::filesystem::path& path,
                                    const DisparityImage& disparity);

}  // namespace sprout

#endif  // SPROUT_COMMON_PICTURE_WRITE_IMAGE_H_
