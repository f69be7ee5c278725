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

#include <bit>
#include <cstdint>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace sprout::refine {
namespace HWY_NAMESPACE {

using Bytes = uint8_t __attribute__((vector_size(16)));
using Words = uint16_t __attribute__((vector_size(16)));
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

// The lanes of `a` and `b`, one behind the other, that have these numbers.
template <int... kFrom, typename Lanes>
HWY_INLINE Lanes Shuffled(Lanes a, Lanes b) {
#ifdef __clang__
  return __builtin_shufflevector(a, b, kFrom...);
#else  // GCC has that from version 12 on
  return __builtin_shuffle(a, b, Lanes{kFrom...});
#endif
}

template <int... kFrom, typename Lanes>
HWY_INLINE Lanes Shuffled(Lanes x) {
  return Shuffled<kFrom...>(x, x);
}

// Bytes as halves of words.
static_assert(std::endian::native == std::endian::little);

// The lanes from 8 · kHalf on.
template <int kHalf>
HWY_INLINE Words Widened(Bytes x) {
  constexpr int kAt = 8 * kHalf;
  return reinterpret_cast<Words>(Shuffled<kAt, 16, kAt + 1, 16, kAt + 2, 16, kAt + 3, 16, kAt + 4,
                                          16, kAt + 5, 16, kAt + 6, 16, kAt + 7, 16>(x, Bytes{}));
}

// Joins two vectors whose lanes are at most 255.
HWY_INLINE Bytes Narrowed(Words low, Words high) {
  return Shuffled<0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30>(
      reinterpret_cast<Bytes>(low), reinterpret_cast<Bytes>(high));
}

HWY_INLINE uint16_t LeastLane(Words x) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_SSE4  // one instruction
  return static_cast<uint16_t>(
      _mm_extract_epi16(_mm_minpos_epu16(reinterpret_cast<__m128i>(x)), 0));
#else
  x = Least(x, Shuffled<4, 5, 6, 7, 0, 1, 2, 3>(x));
  x = Least(x, Shuffled<2, 3, 0, 1, 2, 3, 0, 1>(x));
  return x[0] < x[1] ? x[0] : x[1];
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::refine
HWY_AFTER_NAMESPACE();

#endif  // once for each instruction set
