#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace sprout {

/// The texts of the elements one behind the other, a separator between them.
template <typename Elements, typename TextOf = std::identity>
std::string Joined(std::string_view separator, const Elements& elements,
                   const TextOf& text_of = {}) {
  std::string text;
  for (const auto& element : elements) {
    if (!text.empty()) text += separator;
    text += std::invoke(text_of, element);
  }
  return text;
}

/// `more` behind `text`, with "; " between the two if neither is empty.
inline std::string JoinedTexts(std::string text, std::string_view more) {
  if (!text.empty() && !more.empty()) text += "; ";
  return text.append(more);
}

}  // namespace sprout
