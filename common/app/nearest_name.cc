#include "common/app/nearest_name.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace sprout {
namespace {

// Optimal string alignment: the edits that make one text the other, each letter edited once.
size_t EditsBetween(const std::string& a, const std::string& b) {
  std::vector<std::vector<size_t>> edits(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) {
    for (size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        edits[i][j] = i + j;
        continue;
      }
      const size_t replaced = edits[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      edits[i][j] = std::min({replaced, edits[i - 1][j] + 1, edits[i][j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        edits[i][j] = std::min(edits[i][j], edits[i - 2][j - 2] + 1);
      }
    }
  }
  return edits[a.size()][b.size()];
}

// A beginning this short is one of too many names.
constexpr size_t kMinBeginning = 3;

}  // namespace

std::string NearestName(const std::string& word, std::span<const std::string> names) {
  std::string nearest;
  size_t fewest = std::max<size_t>(1, word.size() / 3) + 1;
  for (const std::string& name : names) {
    const bool is_beginning = word.size() >= kMinBeginning && name.starts_with(word);
    const size_t edits = is_beginning ? 1 : EditsBetween(word, name);
    if (edits >= fewest || edits >= name.size()) continue;
    fewest = edits;
    nearest = name;
  }
  return nearest;
}

}  // namespace sprout
