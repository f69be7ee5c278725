// Neighbouring pixels of a band's table, for each instruction set: included by growth.cc and
// growth_tables.cc, which Highway compiles once for each. No include guard of the usual kind for
// that reason.
#if defined(SPROUT_SERVICES_GROW_LEFT_PIXELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_LEFT_PIXELS_INL_H_
#undef SPROUT_SERVICES_GROW_LEFT_PIXELS_INL_H_
#else
#define SPROUT_SERVICES_GROW_LEFT_PIXELS_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <bit>
#include <cstring>

#include "services/grow/growth_band.h"

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// As many as D, a tag of int32_t, has lanes.
template <class D>
class LeftPixels {
 public:
  using V = hn::Vec<D>;

  HWY_INLINE LeftPixels(V candidates, V priors, V disparities)
      : numbers_(candidates),
        places_(hn::Or(hn::And(priors, hn::Set(D(), 0xffff)), hn::ShiftLeft<16>(disparities))) {}

  // Those from `first` on.
  explicit HWY_INLINE LeftPixels(const LeftPixel* first) {
    Memory memory;
    std::memcpy(memory.data(), first, sizeof(Memory));
    hn::LoadInterleaved2(D(), memory.data(), numbers_, places_);
  }

  HWY_INLINE void Store(LeftPixel* first) const {
    Memory memory;
    hn::StoreInterleaved2(numbers_, places_, D(), memory.data());
    std::memcpy(static_cast<void*>(first), memory.data(), sizeof(Memory));
  }

  HWY_INLINE V priors() const { return hn::ShiftRight<16>(hn::ShiftLeft<16>(places_)); }
  HWY_INLINE V disparities() const { return hn::ShiftRight<16>(places_); }

  HWY_INLINE void ReplaceUnless(hn::Mask<D> mask, const LeftPixels& others) {
    numbers_ = hn::IfThenElse(mask, numbers_, others.numbers_);
    places_ = hn::IfThenElse(mask, places_, others.places_);
  }

 private:
  // A pixel is two numbers: candidates or a link, and prior with the disparity above it.
  static_assert(sizeof(LeftPixel) == 2 * sizeof(int32_t) &&
                std::endian::native == std::endian::little);
  using Memory = std::array<int32_t, 2 * hn::MaxLanes(D())>;

  V numbers_, places_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
