#ifndef SPROUT_COMMON_APP_HELP_TEXT_H_
#define SPROUT_COMMON_APP_HELP_TEXT_H_

#include <cstddef>
#include <string>

namespace sprout {

/// Columns of a terminal that a line of help may fill.
inline constexpr size_t kHelpColumns = 100;

/// Breaks lines longer than kHelpColumns at spaces. They continue indented like their beginning or,
/// for a flag ("  --name ..."), like its description.
/// @param description_column  where the descriptions of flags begin.
std::string WrapLines(const std::string& text, size_t description_column);

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_HELP_TEXT_H_
