#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace sprout {

/// Columns of a terminal that a line of help may fill.
inline constexpr size_t kHelpColumns = 100;

/// Breaks lines longer than kHelpColumns at spaces. They continue indented like their beginning or,
/// for a flag ("  --name ..."), like its description.
/// @param description_column  where the descriptions of flags begin.
std::string WrapLines(const std::string& text, size_t description_column);

/// What somebody who wrote `word` may have meant: the name with the fewest letters inserted, left
/// out, replaced, or swapped with the next one. At most a third of the word's letters (and one in a
/// short word); any number at its end if they were left out ("conf" for "config").
/// @returns the first of the nearest names, or an empty text. O(names × letters²).
std::string NearestName(const std::string& word, std::span<const std::string> names);

}  // namespace sprout
