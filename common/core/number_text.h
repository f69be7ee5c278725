#ifndef SPROUT_COMMON_CORE_NUMBER_TEXT_H_
#define SPROUT_COMMON_CORE_NUMBER_TEXT_H_

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>

namespace sprout {

/// The text without blanks and line ends at its ends.
inline std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const size_t first = text.find_first_not_of(kSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
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

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_NUMBER_TEXT_H_
