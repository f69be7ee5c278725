#include "services/capture/read_image.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <system_error>

#include "common/config/config.h"
#include "common/core/image.h"

namespace sprout {

bool IsFile(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

cv::Mat ReadImage(const std::filesystem::path& path, int flags) {
  cv::Mat image;
  try {
    image = cv::imread(path.string(), flags | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {  // hostile sizes; an empty image says it all
  }
  if (image.empty()) {
    throw ConfigError("image " + path.string() +
                      ": cannot be decoded; allowed: a readable PNG, JPEG or PPM file");
  }
  if (std::max(image.cols, image.rows) > kMaxSide ||
      int64_t{image.cols} * image.rows > kMaxPixels) {
    throw ConfigError("image " + path.string() + ": " + SizeText(image.size()) +
                      " px; allowed: 1 to " + std::to_string(kMaxSide) + " px a side and " +
                      std::to_string(kMaxPixels) + " pixels");
  }
  return image;
}

void RequireSize(const std::filesystem::path& path, cv::Size size, cv::Size expected) {
  if (size == expected) return;
  throw ConfigError("scene file " + path.string() + ": " + SizeText(size) +
                    " px; allowed: " + SizeText(expected) + " px, as the left image has");
}

}  // namespace sprout
