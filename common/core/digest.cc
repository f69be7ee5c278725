#include "common/core/digest.h"

#include <xxhash.h>

#include <cinttypes>
#include <cstdio>

namespace sprout {

std::string Digest(std::string_view bytes) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, XXH3_64bits(bytes.data(), bytes.size()));
  return text;
}

}  // namespace sprout
