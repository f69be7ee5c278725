#ifndef SPROUT_SERVICES_CAPTURE_IMAGE_LIST_H_
#define SPROUT_SERVICES_CAPTURE_IMAGE_LIST_H_

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

namespace sprout::capture {

/// Images whose names have a number, such as left_%04d.png. The list begins at the first existing
/// number from 0 to 10 and ends before the first missing one.
class ImageList {
 public:
  /// @throws ConfigError naming an invalid pattern, or a list without an image.
  explicit ImageList(const std::string& pattern);

  /// Whether there is one more.
  bool HasNext() const;

  /// @pre HasNext().
  /// @throws ConfigError naming a file that cannot be used.
  cv::Mat Next();

 private:
  std::filesystem::path File(int number) const;

  std::string before_;  // the number
  std::string after_;
  size_t digits_ = 0;  // at least this many
  int next_ = 0;
};

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_IMAGE_LIST_H_
