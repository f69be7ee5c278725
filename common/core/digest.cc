#include "common/core/digest.h"

#include <xxhash.h>

#include <cinttypes>
#include <cstdio>

namespace sprout {

uint64_t Hash(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::string Digest(std::string_view bytes) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, Hash(bytes));
  return text;
}

}  // namespace sprout
