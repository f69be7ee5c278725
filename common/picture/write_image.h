#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"
#include "common/core/result.h"

namespace sprout {

// All write the whole file or none (see OutputFile); errors name path and reason.

/// Takes what one of them returned. @throws std::runtime_error when it is an error.
void RequireWritten(const Result<void>& written);

/// Writes a picture (8UC1 grey or 8UC3 BGR), or a map (16UC1), as PNG.
[[nodiscard]] Result<void> WritePng(const std::filesystem::path& path, const cv::Mat& picture);

/// Largest depth of WriteDepthPng(), m: 65535 mm.
inline constexpr double kMaxPngDepthM = 65.535;

/// Writes depths, m, as PNG of 16 bits in mm; 0: none (NaN), or more than kMaxPngDepthM.
[[nodiscard]] Result<void> WriteDepthPng(const std::filesystem::path& path,
                                         const cv::Mat1f& depth_m);

/// Writes numbers as PFM: one channel, 32-bit float, little-endian, bottom row first.
[[nodiscard]] Result<void> WritePfm(const std::filesystem::path& path, const cv::Mat1f& values);

/// Writes disparities as PFM, the format of Middlebury's ground truth: px, +inf where there is no
/// disparity.
[[nodiscard]] Result<void> WritePfm(const std::filesystem::path& path,
                                    const DisparityImage& disparity);

}  // namespace sprout
