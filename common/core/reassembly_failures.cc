#include "common/core/reassembly_failures.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "common/core/number_text.h"

namespace sprout {

int64_t ReassemblyFailures() {
  std::ifstream file("/proc/net/snmp");
  return ReassemblyFailuresIn(std::string(std::istreambuf_iterator<char>(file), {}));
}

int64_t ReassemblyFailuresIn(std::string_view snmp) {
  std::vector<std::string_view> names;  // of the columns: the first of two lines that begin alike
  for (const std::string_view line : SplitAt('\n', snmp)) {
    if (!line.starts_with("Ip: ")) continue;
    const std::vector<std::string_view> words = SplitAt(' ', line);
    const auto column = std::ranges::find(names, "ReasmFails") - names.begin();
    if (column < std::min(std::ssize(names), std::ssize(words))) {
      return ParseNumber<int64_t>(words[static_cast<size_t>(column)]).value_or(0);
    }
    names = words;
  }
  return 0;
}

}  // namespace sprout
