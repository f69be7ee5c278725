#ifndef SPROUT_COMMON_MESSAGES_SHORTENED_H_
#define SPROUT_COMMON_MESSAGES_SHORTENED_H_

#include <cstddef>
#include <string>

namespace sprout {

/// The first bytes of a text, without cutting a UTF-8 character in half.
inline std::string Shortened(const std::string& text, size_t longest) {
  if (text.size() <= longest) return text;
  size_t length = longest;
  while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xc0) == 0x80) --length;
  return text.substr(0, length);
}

}  // namespace sprout

#endif  // SPROUT_COMMON_MESSAGES_SHORTENED_H_
