#ifndef SPROUT_SERVICES_CAPTURE_IMAGE_LIST_H_
#define SPROUT_SERVICES_CAPTURE_IMAGE_LIST_H_

#include <string>
#include <vector>

namespace sprout::capture {

/// The images whose names are a pattern with one number, such as left_%04d.png, in the order of
/// their numbers.
/// @throws ConfigError naming an invalid pattern, or one that no image's name is.
std::vector<std::string> ImageList(const std::string& pattern);

}  // namespace sprout::capture

#endif  // SPROUT_SERVICES_CAPTURE_IMAGE_LIST_H_
