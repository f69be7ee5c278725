#ifndef SPROUT_COMMON_PICTURE_HTML_H_
#define SPROUT_COMMON_PICTURE_HTML_H_

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace sprout {

/// Text as a page shows it: &, <, > and " stand for themselves. O(length).
std::string EscapedHtml(std::string_view text);

/// Bytes of a picture inside a page that is one file: what stands behind src= of an <img>.
/// @param type  "image/png", "image/jpeg". O(bytes).
std::string DataUrl(std::string_view type, std::span<const uint8_t> bytes);

}  // namespace sprout

#endif  // SPROUT_COMMON_PICTURE_HTML_H_
