#include "common/config/config_difference.h"

#include <algorithm>
#include <map>

#include "common/core/number_text.h"

namespace sprout {
namespace {

using Values = std::map<std::string, std::string, std::less<>>;

// Values by key. Protobuf's parser is not used: it refuses a text with an enumerator that it does
// not know. ConfigText() prints "NAME {", "KEY: VALUE" and "}", each on a line of its own.
Values ValuesOf(std::string_view text) {
  Values values;
  std::vector<std::string> sections;
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = Trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with(" {")) {
      const std::string outer = sections.empty() ? "" : sections.back();
      sections.push_back(outer + std::string(line.substr(0, line.size() - 2)) + ".");
    } else if (line == "}") {
      if (!sections.empty()) sections.pop_back();
    } else if (const size_t colon = line.find(": "); colon != std::string_view::npos) {
      const std::string section = sections.empty() ? "" : sections.back();
      std::string& value = values[section + std::string(line.substr(0, colon))];
      value += (value.empty() ? "" : " ") + std::string(line.substr(colon + 2));
    }
  }
  return values;
}

std::string ValueIn(const Values& values, const std::string& key) {
  const auto value = values.find(key);
  return value == values.end() ? "none" : value->second;
}

}  // namespace

std::vector<ConfigDifference> ConfigDifferences(std::string_view a, std::string_view b) {
  const Values in_a = ValuesOf(a);
  const Values in_b = ValuesOf(b);
  Values all = in_a;
  all.insert(in_b.begin(), in_b.end());
  std::vector<ConfigDifference> differences;
  for (const auto& [key, unused] : all) {
    ConfigDifference difference{.key = key, .a = ValueIn(in_a, key), .b = ValueIn(in_b, key)};
    if (difference.a != difference.b) differences.push_back(std::move(difference));
  }
  return differences;
}

}  // namespace sprout
