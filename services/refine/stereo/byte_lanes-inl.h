// Sixteen numbers at once, for each instruction set: included by files that Highway compiles once
// for each. They use the compiler's vector extension, which maps them to the instruction set. Whole
// numbers only, so the result is the same with any. It has no usual include guard because it is
// included several times.
#if defined(SPROUT_SERVICES_REFINE_STEREO_BYTE_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_REFINE_STEREO_BYTE_LANES_INL_H_
#undef SPROUT_SERVICES_REFINE_STEREO_BYTE_LANES_INL_H_
#else
#define SPROUT_SERVICES_REFINE_STEREO_BYTE_LANES_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace sprout::refine {
namespace HWY_NAMESPACE {

using Bytes = uint8_t __attribute__((vector_size(16)));
using Words = uint16_t __attribute__((vector_size(16)));
using HalfBytes = uint8_t __attribute__((vector_size(8)));
constexpr int kLanes = 16;
constexpr int kWords = 8;

HWY_INLINE Bytes Load(const uint8_t* from) {
  Bytes bytes;
  std::memcpy(&bytes, from, sizeof bytes);
  return bytes;
}

HWY_INLINE Words Load(const uint16_t* from) {
  Words words;
  std::memcpy(&words, from, sizeof words);
  return words;
}

HWY_INLINE void Store(Bytes bytes, uint8_t* to) { std::memcpy(to, &bytes, sizeof bytes); }
HWY_INLINE void Store(Words words, uint16_t* to) { std::memcpy(to, &words, sizeof words); }

HWY_INLINE Bytes Least(Bytes a, Bytes b) { return a < b ? a : b; }
HWY_INLINE Words Least(Words a, Words b) { return a < b ? a : b; }

// The lanes from 8 · kHalf on.
template <int kHalf>
HWY_INLINE Words Widened(Bytes x) {
  constexpr int kFrom = 8 * kHalf;
  const HalfBytes half = __builtin_shufflevector(x, x, kFrom, kFrom + 1, kFrom + 2, kFrom + 3,
                                                 kFrom + 4, kFrom + 5, kFrom + 6, kFrom + 7);
  return __builtin_convertvector(half, Words);
}

// Joins two vectors whose lanes are at most 255.
HWY_INLINE Bytes Narrowed(Words low, Words high) {
  return __builtin_shufflevector(__builtin_convertvector(low, HalfBytes),
                                 __builtin_convertvector(high, HalfBytes), 0, 1, 2, 3, 4, 5, 6, 7,
                                 8, 9, 10, 11, 12, 13, 14, 15);
}

HWY_INLINE uint16_t LeastLane(Words x) {
  x = Least(x, __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3));
  x = Least(x, __builtin_shufflevector(x, x, 2, 3, 0, 1, 2, 3, 0, 1));
  return x[0] < x[1] ? x[0] : x[1];
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::refine
HWY_AFTER_NAMESPACE();

#endif  // once for each instruction set
