#include "services/tools/log/print_line.h"

#include <iostream>

#include "common/core/printable.h"

namespace sprout::log {

void PrintLine(const std::string& text) { std::cout << Printable(text) << "\n"; }

void PrintWarning(const std::string& text) {
  std::cerr << "sprout-log: " << Printable(text) << "\n";
}

}  // namespace sprout::log
