#pragma once

#include <string>

namespace sprout::log {

// One line, Printable() whatever names of files and channels are in it.

void PrintLine(const std::string& text);     ///< to stdout
void PrintWarning(const std::string& text);  ///< to stderr, behind the program's name

}  // namespace sprout::log
