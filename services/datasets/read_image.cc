#include "services/datasets/read_image.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <string_view>
#include <system_error>

#include "common/config/config.h"
#include "common/core/image.h"

namespace sprout::datasets {
namespace {

// OpenCV would try every decoder that it was built with, and all libraries behind these; which one,
// the first bytes of the file decide.
bool IsOfAllowedFormat(const std::filesystem::path& path) {
  using namespace std::string_view_literals;
  std::string begin(8, '\0');
  std::ifstream(path, std::ios::binary)
      .read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return std::ranges::any_of(
      std::array{"\x89PNG\r\n\x1a\n"sv, "\xff\xd8\xff"sv, "P2"sv, "P3"sv, "P5"sv, "P6"sv},
      [&](std::string_view magic) { return begin.starts_with(magic); });
}

}  // namespace

bool IsFile(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

cv::Mat ReadImage(const std::filesystem::path& path, int flags) {
  cv::Mat image;
  try {
    if (IsOfAllowedFormat(path)) {
      image = cv::imread(path.string(), flags | cv::IMREAD_IGNORE_ORIENTATION);
    }
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

}  // namespace sprout::datasets
