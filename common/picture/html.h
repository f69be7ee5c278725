#ifndef SPROUT_COMMON_PICTURE_HTML_H_
#define SPROUT_COMMON_PICTURE_HTML_H_

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sprout {

/// Text escaped for HTML: &, <, > and " are shown as such. O(length).
std::string EscapedHtml(std::string_view text);

/// Bytes of a picture embedded in a page: the value of src= of an <img>.
/// @param type  "image/png", "image/jpeg". O(bytes).
std::string DataUrl(std::string_view type, std::span<const uint8_t> bytes);

/// A picture as PNG inside the page, with a caption below it. @param caption  HTML. O(pixels).
std::string FigureHtml(const cv::Mat3b& picture, std::string_view caption);

/// The start of a page, with the style that all reports share.
/// @param style  CSS that this report adds.
std::string PageStart(std::string_view title, std::string_view style = "");
std::string PageEnd();

/// A table of texts, which are escaped; the first row is its head. O(length).
std::string TableHtml(const std::vector<std::vector<std::string>>& rows);

}  // namespace sprout

#endif  // SPROUT_COMMON_PICTURE_HTML_H_
