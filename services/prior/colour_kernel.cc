// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include "services/prior/colour_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/prior/colour_kernel.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sprout::prior {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, ColourSeeds::kAtOnce>;
using V = hn::Vec<D>;

HWY_INLINE V Square(V x) { return hn::Mul(x, x); }

// Added up by fours whatever the registers' width: sums of floats depend on the order.
HWY_INLINE float SumByFours(const float* numbers, size_t count) {
  float sums[4] = {};
  for (size_t i = 0; i < count; i += 4) {
    for (size_t k = 0; k < 4; ++k) sums[k] += numbers[i + k];
  }
  return sums[0] + sums[1] + sums[2] + sums[3];
}

}  // namespace

double ColourTermOnTarget(const ColourSeeds& seeds, const ColourPixel& pixel) {
  // Of a seed whose colour is three ranges off: where all are, colours hardly tell.
  constexpr float kNoSupport = 0.01F;
  const D d;
  const V one = hn::Set(d, 1.0F);
  ColourSeeds::Numbers support, near_support;  // near less far
  const auto off = [&](float value, const ColourSeeds::Numbers& numbers, size_t i)
                       HWY_ATTR { return hn::Sub(hn::Set(d, value), hn::LoadU(d, &numbers[i])); };
  for (size_t i = 0; i < seeds.count; i += hn::MaxLanes(d)) {
    const V along_row = hn::Mul(hn::LoadU(d, &seeds.per_column[i]), off(pixel.u, seeds.u, i));
    const V along_column = hn::Mul(hn::LoadU(d, &seeds.per_row[i]), off(pixel.v, seeds.v, i));
    const V at_pixel = hn::Add(hn::Add(hn::LoadU(d, &seeds.counts[i]), along_row), along_column);
    const V above = hn::Sub(at_pixel, hn::Set(d, pixel.middle));
    const V difference = hn::Add(
        hn::Add(hn::Abs(off(pixel.blue, seeds.blue, i)), hn::Abs(off(pixel.green, seeds.green, i))),
        hn::Abs(off(pixel.red, seeds.red, i)));
    // Half the weight for planes that miss both labels by edge_px.
    const V miss =
        hn::Mul(hn::Sub(hn::Abs(above), hn::Set(d, pixel.half_gap)), hn::Set(d, pixel.per_miss));
    const V unlike = hn::Add(one, Square(hn::Mul(difference, hn::Set(d, pixel.per_range))));
    const V weight = hn::Div(one, hn::Mul(hn::Add(one, Square(miss)), Square(unlike)));
    hn::StoreU(weight, d, &support[i]);
    hn::StoreU(hn::CopySign(weight, above), d, &near_support[i]);
  }
  return double{SumByFours(near_support.data(), seeds.count)} /
         (kNoSupport + SumByFours(support.data(), seeds.count));
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::prior
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::prior {

HWY_EXPORT(ColourTermOnTarget);

double ColourTerm(const ColourSeeds& seeds, const ColourPixel& pixel) {
  return HWY_DYNAMIC_DISPATCH(ColourTermOnTarget)(seeds, pixel);
}

}  // namespace sprout::prior
#endif  // HWY_ONCE
