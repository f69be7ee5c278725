#include "common/app/help_text.h"

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <vector>

namespace sprout {
namespace {

// Characters of UTF-8.
size_t Columns(const std::string& text) {
  return static_cast<size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<uint8_t>(c) & 0xc0) != 0x80; }));
}

std::string WrapLine(const std::string& line, size_t description_column) {
  if (Columns(line) <= kHelpColumns) return line;
  const size_t start = std::min(line.find_first_not_of(' '), line.size());
  const size_t indent = start == 2 ? description_column : start;
  std::istringstream words(line.substr(start));
  std::string wrapped;
  std::string row(start, ' ');
  bool is_fresh = true;  // there is no word in the row yet
  // Empty words stand between spaces that follow each other, as before a description.
  for (std::string word; std::getline(words, word, ' ');) {
    if (!is_fresh && Columns(row) + 1 + Columns(word) > kHelpColumns) {
      row.erase(row.find_last_not_of(' ') + 1);
      wrapped += row + "\n";
      row = std::string(indent, ' ');
      is_fresh = true;
    }
    if (is_fresh && word.empty()) continue;
    row += is_fresh ? word : " " + word;
    is_fresh = false;
  }
  return wrapped + row;
}

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

std::string WrapLines(const std::string& text, size_t description_column) {
  std::istringstream lines(text);
  std::string wrapped;
  for (std::string line; std::getline(lines, line);) {
    wrapped += WrapLine(line, description_column) + "\n";
  }
  return wrapped;
}

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
