#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sprout {

/// Text of others (names of files, topics and channels, reasons) for a terminal: in one line, and
/// without the sequences that move the cursor. Control characters, and bytes that are not UTF-8, as
/// \xNN.
std::string Printable(std::string_view text);

/// Printable text of several lines: ends of lines and tabs stay.
std::string PrintableLines(std::string_view text);

/// The text quoted as one word of a shell's command line.
inline std::string ShellWord(const std::string& text) {
  constexpr char kPlain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-./:=";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos) return text;
  std::string word = "'";
  for (const char letter : text) word += letter == '\'' ? "'\\''" : std::string(1, letter);
  return word + "'";
}

/// The first bytes of a text, without cutting a UTF-8 character in half.
inline std::string Shortened(const std::string& text, size_t longest) {
  if (text.size() <= longest) return text;
  size_t length = longest;
  while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xc0) == 0x80) --length;
  return text.substr(0, length);
}

}  // namespace sprout
