#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace sprout {

/// A key whose values differ in two configurations.
struct ConfigDifference {
  std::string key;  ///< "grow.sigma_p_px"
  std::string a;    ///< its value as text; "none" where the configuration lacks the key
  std::string b;

  bool operator==(const ConfigDifference&) const = default;
};

/// The differences between two effective configurations (texts as ConfigText() prints them), sorted
/// by key. They may come from other versions of the programs: keys and values need not be known
/// here.
std::vector<ConfigDifference> ConfigDifferences(std::string_view a, std::string_view b);

}  // namespace sprout
