#ifndef SPROUT_COMMON_SCENES_READ_IMAGE_H_
#define SPROUT_COMMON_SCENES_READ_IMAGE_H_

#include <filesystem>
#include <opencv2/core.hpp>

namespace sprout::scenes {

bool IsFile(const std::filesystem::path& path);

/// Reads a PNG, JPEG, PGM or PPM file.
/// @param flags  cv::imread()'s.
/// @throws ConfigError with the text of DecodeImageFile().
cv::Mat ReadImage(const std::filesystem::path& path, int flags);

/// @throws ConfigError naming the file and both sizes when they differ.
/// @param expected  of the left image.
void RequireSize(const std::filesystem::path& path, cv::Size size, cv::Size expected);

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_READ_IMAGE_H_
