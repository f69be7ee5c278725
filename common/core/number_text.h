#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace sprout {

/// The text without blanks and line ends at its ends.
inline std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

/// The parts of a text between separators, also empty ones.
inline std::vector<std::string_view> SplitAt(char separator, std::string_view text) {
  std::vector<std::string_view> parts;
  for (size_t begin = 0; begin <= text.size(); begin += parts.back().size() + 1) {
    parts.push_back(text.substr(begin, text.find(separator, begin) - begin));
  }
  return parts;
}

/// Parses a finite number and nothing else. Independent of the locale, unlike std::stod.
template <typename Number>
std::optional<Number> ParseNumber(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  if (!std::isfinite(static_cast<double>(number))) return {};
  return number;
}

/// Parses numbers with a separator, and blanks, between them; nothing when one is none.
template <typename Number>
std::optional<std::vector<Number>> ParseNumbers(char separator, std::string_view text) {
  std::vector<Number> numbers;
  for (const std::string_view part : SplitAt(separator, text)) {
    const std::optional<Number> number = ParseNumber<Number>(Trimmed(part));
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

/// Parses a size such as 640x480.
inline std::optional<std::pair<int, int>> ParseSize(std::string_view text) {
  const std::vector<std::string_view> sides = SplitAt('x', text);
  if (sides.size() != 2) return {};
  const auto width = ParseNumber<int>(sides[0]);
  const auto height = ParseNumber<int>(sides[1]);
  if (!width || !height) return {};
  return std::pair(*width, *height);
}

}  // namespace sprout
