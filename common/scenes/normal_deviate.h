#ifndef SPROUT_COMMON_SCENES_NORMAL_DEVIATE_H_
#define SPROUT_COMMON_SCENES_NORMAL_DEVIATE_H_

#include <cstdint>

#include "common/scenes/solid_texture.h"

namespace sprout::scenes {

/// A normal deviate from a key: the sum of twelve uniform numbers less its mean (Irwin and Hall).
/// Variance 1, no value beyond ±6, and no libm function that differs between machines.
inline double NormalDeviate(uint64_t key) {
  uint64_t sum = 0;
  for (uint64_t word = 0; word < 3; ++word) {
    const uint64_t bits = Scramble(key + word);
    for (int part = 0; part < 4; ++part) sum += bits >> (16 * part) & 0xffff;
  }
  return (static_cast<double>(sum) - 12 * 32767.5) / 65536;
}

}  // namespace sprout::scenes

#endif  // SPROUT_COMMON_SCENES_NORMAL_DEVIATE_H_
