#ifndef SPROUT_COMMON_CORE_PRINTABLE_H_
#define SPROUT_COMMON_CORE_PRINTABLE_H_

#include <string>
#include <string_view>

namespace sprout {

/// Text of others (names of files, topics and channels, reasons) for a terminal: in one line, and
/// without the sequences that move the cursor. Control characters, and bytes that are not UTF-8, as
/// \xNN.
std::string Printable(std::string_view text);

/// Printable text of several lines: ends of lines and tabs stay.
std::string PrintableLines(std::string_view text);

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_PRINTABLE_H_
