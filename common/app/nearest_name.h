#ifndef SPROUT_COMMON_APP_NEAREST_NAME_H_
#define SPROUT_COMMON_APP_NEAREST_NAME_H_

#include <span>
#include <string>

namespace sprout {

/// What somebody who wrote `word` may have meant: the name with the fewest letters inserted, left
/// out, replaced, or swapped with the next one. At most a third of the word's letters (and one in a
/// short word); any number at its end if they were left out ("conf" for "config").
/// @returns the first of the nearest names, or an empty text. O(names × letters²).
std::string NearestName(const std::string& word, std::span<const std::string> names);

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_NEAREST_NAME_H_
