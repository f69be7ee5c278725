#include "services/capture/image_list.h"

#include <opencv2/imgcodecs.hpp>

#include "common/config/config.h"
#include "common/core/number_text.h"
#include "common/picture/read_image.h"
#include "services/datasets/read_image.h"

namespace sprout::capture {

ImageList::ImageList(const std::string& pattern) {
  const auto refuse = [&](const std::string& why) {
    throw ConfigError("image list " + pattern + ": " + why);
  };
  const size_t percent = pattern.find('%');
  const size_t end = pattern.find('d', percent);
  before_ = pattern.substr(0, percent);
  if (end != std::string::npos) after_ = pattern.substr(end + 1);
  const std::string width = pattern.substr(percent + 1, end - percent - 1);
  const auto digits = width.empty() ? 0 : ParseNumber<int>(width);
  constexpr int kMostDigits = 20;
  if (end == std::string::npos || after_.find('%') != std::string::npos || !digits || *digits < 0 ||
      *digits > kMostDigits) {
    refuse("not a name with one number; allowed: such as left_%04d.png");
  }
  digits_ = static_cast<size_t>(*digits);
  constexpr int kLastFirst = 10;
  while (!HasNext()) {
    if (++next_ > kLastFirst) refuse("cannot be opened: no image with a number from 0 to 10");
  }
}

bool ImageList::HasNext() const { return datasets::IsFile(File(next_)); }

cv::Mat ImageList::Next() {
  Result<cv::Mat> image = DecodeImageFile(File(next_), cv::IMREAD_UNCHANGED, kCameraFormats);
  if (!image) throw ConfigError(image.error().text);
  ++next_;
  return *image;
}

std::filesystem::path ImageList::File(int number) const {
  const std::string text = std::to_string(number);
  const size_t zeros = digits_ > text.size() ? digits_ - text.size() : 0;
  return before_ + std::string(zeros, '0') + text + after_;
}

}  // namespace sprout::capture
