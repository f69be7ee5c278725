#include "common/app/help_text.h"

#include <algorithm>
#include <cstdint>
#include <sstream>

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

}  // namespace

std::string WrapLines(const std::string& text, size_t description_column) {
  std::istringstream lines(text);
  std::string wrapped;
  for (std::string line; std::getline(lines, line);) {
    wrapped += WrapLine(line, description_column) + "\n";
  }
  return wrapped;
}

}  // namespace sprout
