#include "common/scenes/read_image.h"

#include <system_error>

#include "common/config/config_error.h"
#include "common/core/image.h"
#include "common/picture/read_image.h"

namespace sprout::scenes {

bool IsFile(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

cv::Mat ReadImage(const std::filesystem::path& path, int flags) {
  Result<cv::Mat> image = DecodeImageFile(path, flags, kPictureFormats);
  if (!image) throw ConfigError(image.error().text);
  return *image;
}

void RequireSize(const std::filesystem::path& path, cv::Size size, cv::Size expected) {
  if (size == expected) return;
  throw ConfigError("scene file " + path.string() + ": " + SizeText(size) +
                    " px; allowed: " + SizeText(expected) + " px, as the left image has");
}

}  // namespace sprout::scenes
