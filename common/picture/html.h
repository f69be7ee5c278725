#ifndef SPROUT_COMMON_PICTURE_HTML_H_
#define SPROUT_COMMON_PICTURE_HTML_H_

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace sprout {

/// Text escaped for HTML: &, <, > and " are shown as such. O(length).
std::string EscapedHtml(std::string_view text);

/// Bytes of a picture embedded in a page: the value of src= of an <img>.
/// @param type  "image/png", "image/jpeg". O(bytes).
std::string DataUrl(std::string_view type, std::span<const uint8_t> bytes);

}  // namespace sprout

#endif  // SPROUT_COMMON_PICTURE_HTML_H_
