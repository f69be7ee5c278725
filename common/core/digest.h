#ifndef SPROUT_COMMON_CORE_DIGEST_H_
#define SPROUT_COMMON_CORE_DIGEST_H_

#include <cstdint>
#include <string>
#include <string_view>

namespace sprout {

/// XXH3 (64 bits) of the bytes; the same on every machine.
uint64_t Hash(std::string_view bytes);

/// Hash() as 16 hexadecimal digits. Tells apart configurations and calibrations; no protection
/// against forgery.
std::string Digest(std::string_view bytes);

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_DIGEST_H_
