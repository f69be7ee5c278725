#ifndef SPROUT_COMMON_APP_HELP_TEXT_H_
#define SPROUT_COMMON_APP_HELP_TEXT_H_

#include <CLI/CLI.hpp>
#include <string>

namespace sprout {

/// Columns of a terminal that a line of help may fill.
inline constexpr size_t kHelpColumns = 100;

/// Text whose lines are broken at spaces where they are longer than kHelpColumns. What is broken
/// goes on below its own beginning, or, of a flag ("  --name ..."), below its description.
/// @param description_column  where descriptions of flags begin.
std::string WrapLines(const std::string& text, size_t description_column);

/// Has --help of a program, and of its subcommands, wrapped.
void WrapHelp(CLI::App& flags);

}  // namespace sprout

#endif  // SPROUT_COMMON_APP_HELP_TEXT_H_
