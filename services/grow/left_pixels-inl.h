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

  HWY_INLINE LeftPixels(V energies, V priors, V disparities)
      : numbers_(energies),
        links_(hn::Zero(D())),
        places_(hn::Or(hn::And(priors, hn::Set(D(), 0xffff)), hn::ShiftLeft<16>(disparities))) {}

  // Those from `first` on.
  explicit HWY_INLINE LeftPixels(const LeftPixel* first) {
    Memory memory;
    std::memcpy(memory.data(), first, sizeof(Memory));
    hn::LoadInterleaved3(D(), memory.data(), numbers_, links_, places_);
  }

  HWY_INLINE void Store(LeftPixel* first) const {
    Memory memory;
    hn::StoreInterleaved3(numbers_, links_, places_, D(), memory.data());
    std::memcpy(static_cast<void*>(first), memory.data(), sizeof(Memory));
  }

  HWY_INLINE V energies() const { return numbers_; }
  HWY_INLINE V priors() const { return hn::ShiftRight<16>(hn::ShiftLeft<16>(places_)); }
  HWY_INLINE V disparities() const { return hn::ShiftRight<16>(places_); }

  // Candidates in the place of energies, and new disparities, where the mask is set.
  HWY_INLINE void Replace(hn::Mask<D> mask, V candidates, V disparities) {
    const LeftPixels other(candidates, places_, disparities);
    numbers_ = hn::IfThenElse(mask, other.numbers_, numbers_);
    places_ = hn::IfThenElse(mask, other.places_, places_);
  }

 private:
  // A pixel is three numbers: energy or candidates, link, and prior with the disparity above it.
  static_assert(sizeof(LeftPixel) == 3 * sizeof(int32_t) &&
                std::endian::native == std::endian::little);
  using Memory = std::array<int32_t, 3 * hn::MaxLanes(D())>;

  V numbers_, links_, places_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
