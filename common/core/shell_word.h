#ifndef SPROUT_COMMON_CORE_SHELL_WORD_H_
#define SPROUT_COMMON_CORE_SHELL_WORD_H_

#include <string>

namespace sprout {

/// The text quoted as one word of a shell's command line.
inline std::string ShellWord(const std::string& text) {
  constexpr char kPlain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-./:=";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos) return text;
  std::string word = "'";
  for (const char letter : text) word += letter == '\'' ? "'\\''" : std::string(1, letter);
  return word + "'";
}

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_SHELL_WORD_H_
