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

HWY_INLINE uint16_t LeastLane(Words x) {
  x = Least(x, __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3));
  x = Least(x, __builtin_shufflevector(x, x, 2, 3, 0, 1, 2, 3, 0, 1));
  return x[0] < x[1] ? x[0] : x[1];
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::refine
HWY_AFTER_NAMESPACE();

#endif  // once for each instruction set
