// Costs of four disparities at a pixel, and other code that the parts of the fast growth share.
// Highway compiles this file once for each instruction set, so it has no usual include guard.
#if defined(SPROUT_SERVICES_GROW_WINDOW_COSTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_WINDOW_COSTS_INL_H_
#undef SPROUT_SERVICES_GROW_WINDOW_COSTS_INL_H_
#else
#define SPROUT_SERVICES_GROW_WINDOW_COSTS_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <bit>
#include <cstring>

#include "services/grow/paper/similarity-inl.h"
#include "services/grow/sweep/growth_band.h"

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Values for the disparities d + 1, d, d − 1 and d − 2, in this order: that of the right windows in
// memory.
using DFour = hn::FixedTag<int32_t, 4>;
using Four = hn::Vec<DFour>;
using FourNumbers = std::array<int32_t, 4>;

HWY_INLINE Four LoadFour(const FourNumbers& numbers) { return hn::LoadU(DFour(), numbers.data()); }

HWY_INLINE FourNumbers ToNumbers(Four four) {
  FourNumbers numbers;
  hn::StoreU(four, DFour(), numbers.data());
  return numbers;
}

// Two rows of pixels, one above the other, are read as pairs in one number each, the upper pixel in
// its lower 16 bits. The products of the upper and of the lower pixels, added:
template <class V>
HWY_INLINE V PairProducts(V left, V right) {
  const hn::DFromV<V> d;
#if HWY_ARCH_X86 && HWY_TARGET != HWY_EMU128  // one instruction, which adds neighbours
  const hn::RepartitionToNarrow<decltype(d)> d16;
  V rest = hn::Zero(d);
  return hn::ReorderWidenMulAccumulate(d, hn::BitCast(d16, left), hn::BitCast(d16, right), rest,
                                       rest);
#else
  const V upper = hn::Set(d, 0xffff);
  return hn::Add(hn::Mul(hn::And(left, upper), hn::And(right, upper)),
                 hn::Mul(hn::ShiftRight<16>(left), hn::ShiftRight<16>(right)));
#endif
}

// Eq. (6) as costs, kExcludedCost where a window does not fit. All are whole numbers.
// @param energies  Σ(wL² + wR²), at least 1. @param differences  Σ(wL − wR)². @param distances from
// the prior on either side, counts. @param scale  of GrowthRule::prior_scales. @param fits negative
// where a window does not fit.
template <class F, class V>
HWY_INLINE V EpcCosts(const GrowthRule& rule, F energies, F differences, F distances, F scale,
                      V fits) {
  const hn::DFromV<F> df;
  const hn::DFromV<V> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  const F photo = PhotoCost(differences, energies, hn::Set(df, rule.photo_scale));
  const F prior = PriorCost(distances, scale);
  // Sums over windows that do not fit may lead below 0.
  const F cost = hn::Floor(Clamped(hn::Add(photo, prior), hn::Zero(df), hn::Set(df, kMaxCost)));
  // Added to 2²³ a whole number stands in the bits of the fraction: fewer instructions than
  // ConvertTo(), which minds what is too large.
  const F base = hn::Set(df, 1 << 23);
  const V whole = hn::Sub(hn::BitCast(d, hn::Add(cost, base)), hn::BitCast(d, base));
  static_assert(kExcludedCost == UINT32_MAX >> 3);
  const auto excluded = hn::ShiftRight<3>(hn::BitCast(du, hn::BroadcastSignBit(fits)));
  return hn::Or(whole, hn::BitCast(d, excluded));
}

// The largest disparity whose right window lies in the image, and that a map can hold.
template <class V>
HWY_INLINE V HighestThatFits(V columns) {
  const hn::DFromV<V> d;
  return hn::Min(hn::Sub(columns, hn::Set(d, kWindowRadius)),
                 hn::Set(d, DisparityImage::kMaxWholePx));
}

// A whole number as a divisor.
template <class V>
HWY_INLINE auto AtLeastOne(V number) {
  const hn::DFromV<V> d;
  return hn::ConvertTo(hn::RebindToFloat<decltype(d)>(), hn::Max(number, hn::Set(d, 1)));
}

// Values of eight neighbouring pixels.
struct Eight {
  Four first, last;

  // The four values from the i-th on, for i up to 4.
  template <int i>
  HWY_INLINE Four From() const {
    if constexpr (i == 0) return first;
    if constexpr (i == 4) return last;
    if constexpr (i != 0 && i != 4) return hn::CombineShiftRightLanes<i>(DFour(), last, first);
  }

  // The i-th in all lanes, for i up to 4.
  template <int i>
  HWY_INLINE Four All() const {
    return hn::Broadcast<i % 4>(i < 4 ? first : last);
  }

  // The differences of this vector from `others`, as pairs.
  HWY_INLINE Eight DifferencesFrom(const Eight& others) const {
    const hn::FixedTag<uint16_t, 8> d16;
    const auto difference = [&](Four a, Four b) HWY_ATTR {
      const auto one = hn::BitCast(d16, a);
      const auto other = hn::BitCast(d16, b);
      return hn::BitCast(DFour(), hn::Sub(hn::Max(one, other), hn::Min(one, other)));
    };
    return {difference(first, others.first), difference(last, others.last)};
  }

  HWY_INLINE void AddSquares(const Eight& pairs) {
    first = hn::Add(first, PairProducts(pairs.first, pairs.first));
    last = hn::Add(last, PairProducts(pairs.last, pairs.last));
  }
};

HWY_INLINE Eight PairsOf(const uint8_t* upper, const uint8_t* lower) {
  const hn::FixedTag<uint8_t, 16> d8;
  const hn::FixedTag<uint8_t, 8> d8_half;
  const auto load = [&](const uint8_t* row)
                        HWY_ATTR { return hn::ZeroExtendVector(d8, hn::LoadU(d8_half, row)); };
  const auto both = hn::InterleaveLower(load(upper), load(lower));
  return {hn::BitCast(DFour(), hn::InterleaveLower(both, hn::Zero(d8))),
          hn::BitCast(DFour(), hn::InterleaveUpper(d8, both, hn::Zero(d8)))};
}

// Σ(wL² + wR²) and Σ(wL − wR)² of d + 1, d, d − 1 and d − 2 at a pixel.
struct FourSums {
  Four energies, differences;
};

// Sums them up from the grey values.
// @pre the left window lies in the image, the right window of d leaves it by one column at most.
HWY_INLINE FourSums SumFour(const GrowthBand& band, PixelId pixel, int d) {
  const DFour d4;
  const auto id = static_cast<ptrdiff_t>(pixel);
  const ptrdiff_t stride = band.stride;
  const uint8_t* left = band.left_grey.data() + id - 2 * stride - 2;
  const uint8_t* right = band.right_grey.data() + (id - (d + 1)) - 2 * stride - 2;
  Four cross = hn::Zero(d4);
  Eight left_squares{cross, cross}, right_squares{cross, cross};
  const auto add_rows = [&](const Eight& l, const Eight& r) HWY_ATTR {
    cross = hn::Add(cross, PairProducts(l.All<0>(), r.From<0>()));
    cross = hn::Add(cross, PairProducts(l.All<1>(), r.From<1>()));
    cross = hn::Add(cross, PairProducts(l.All<2>(), r.From<2>()));
    cross = hn::Add(cross, PairProducts(l.All<3>(), r.From<3>()));
    cross = hn::Add(cross, PairProducts(l.All<4>(), r.From<4>()));
    left_squares.AddSquares(l);
    right_squares.AddSquares(r);
  };
  static constexpr uint8_t kNothing[8] = {};  // below the fifth row
  add_rows(PairsOf(left, left + stride), PairsOf(right, right + stride));
  add_rows(PairsOf(left + 2 * stride, left + 3 * stride),
           PairsOf(right + 2 * stride, right + 3 * stride));
  add_rows(PairsOf(left + 4 * stride, kNothing), PairsOf(right + 4 * stride, kNothing));
  const Four left_energy = hn::Add(hn::SumOfLanes(d4, left_squares.first), left_squares.All<4>());
  const Four right_energies =
      hn::Add(hn::Add(hn::Add(right_squares.From<0>(), right_squares.From<1>()),
                      hn::Add(right_squares.From<2>(), right_squares.From<3>())),
              right_squares.From<4>());
  const Four energies = hn::Add(left_energy, right_energies);
  return {energies, hn::Sub(hn::Sub(energies, cross), cross)};
}

// Costs of these disparities.
// @param prior, sigma  of the pixel, counts.
HWY_INLINE Four FourCosts(const GrowthRule& rule, const GrowthBand& band, PixelId pixel, int prior,
                          uint8_t sigma, int d, const FourSums& sums) {
  const DFour d4;
  const auto id = static_cast<ptrdiff_t>(pixel);
  static_assert(DisparityImage::kCountsPerPixel == 1 << 5);
  const Four disparities = hn::Add(hn::Set(d4, d), LoadFour({1, 0, -1, -2}));
  const Four distances = hn::Sub(hn::ShiftLeft<5>(disparities), hn::Set(d4, prior));
  const hn::Rebind<uint8_t, DFour> d8;
  const Four states = hn::PromoteTo(d4, hn::LoadU(d8, band.right.data() + (id - (d + 1))));
  const Four room = hn::Sub(hn::Set(d4, DisparityImage::kMaxWholePx), disparities);
  const Four fits = hn::Or(hn::Or(disparities, room),
                           hn::VecFromMask(d4, hn::Eq(states, hn::Set(d4, RightState::kNoWindow))));
  const hn::RebindToFloat<DFour> df;
  return EpcCosts(rule, AtLeastOne(sums.energies), hn::ConvertTo(df, sums.differences),
                  hn::ConvertTo(df, distances), hn::Set(df, rule.prior_scales[sigma]), fits);
}

HWY_INLINE Four FourCosts(const GrowthRule& rule, const GrowthBand& band, PixelId pixel, int prior,
                          uint8_t sigma, int d) {
  return FourCosts(rule, band, pixel, prior, sigma, d, SumFour(band, pixel, d));
}

// Σ(wL − wL′)² at a pixel, wL′ being the window one pixel before, and the same at the next pixel.
HWY_INLINE FourNumbers TexturesAt(const GrowthBand& band, PixelId pixel) {
  const ptrdiff_t stride = band.stride;
  const uint8_t* left = band.left_grey.data() + static_cast<ptrdiff_t>(pixel) - 2 * stride - 2;
  Eight squares{hn::Zero(DFour()), hn::Zero(DFour())};
  const auto add_rows = [&](const uint8_t* upper, const uint8_t* lower, int step) HWY_ATTR {
    squares.AddSquares(PairsOf(upper, lower).DifferencesFrom(PairsOf(upper - 1, lower - step)));
  };
  static constexpr uint8_t kNothing[8] = {};  // below the fifth row
  add_rows(left, left + stride, 1);
  add_rows(left + 2 * stride, left + 3 * stride, 1);
  add_rows(left + 4 * stride, kNothing, 0);
  return ToNumbers(hn::Add(hn::Add(hn::Add(squares.From<0>(), squares.From<1>()),
                                   hn::Add(squares.From<2>(), squares.From<3>())),
                           squares.From<4>()));
}

// What the sub-pixel step of pixels follows from: Σ(wL − wR)² of d − 1, d and d + 1, and the cost
// of d between those of the two others, in any order.
template <class F, class V>
struct StepWindows {
  F difference_before, difference, difference_behind;
  V cost_of_one, cost, cost_of_other;
  V texture, texture_of_next;  // Σ(wL − wL′)², wL′ one pixel before; the same of the next pixel
  F energy;                    // Σ(wL² + wR²), at least 1
  F distance;                  // d − D_p, counts
};

// Counts from d to the least cost (S2); none where a cost is missing or d is not better than the
// two others. At most 15 counts up, so that rounding leads back to d.
// @param prior_scale  of GrowthRule::prior_scales.
template <class F, class V>
HWY_INLINE V StepsToMinimum(const GrowthRule& rule, const StepWindows<F, V>& of, F prior_scale) {
  const hn::DFromV<V> d;
  const hn::DFromV<F> df;
  const auto missing = hn::Eq(hn::Max(of.cost_of_one, of.cost_of_other), hn::Set(d, kExcludedCost));
  const auto is_least = hn::Gt(hn::Min(of.cost_of_one, of.cost_of_other), of.cost);
  constexpr int kPixel = DisparityImage::kCountsPerPixel;
  const auto number = [&](float value) HWY_ATTR { return hn::Set(df, value); };
  const auto up = hn::Lt(of.difference_behind, of.difference_before);
  const F beside = hn::Min(of.difference_behind, of.difference_before);
  const V texture = hn::IfThenElse(hn::RebindMask(d, up), of.texture, of.texture_of_next);
  const F step = StepToMinimum(
      StepInput<F>{hn::Sub(of.difference, beside), AtLeastOne(texture), of.energy,
                   hn::IfThenElse(up, number(kPixel), number(-kPixel)), of.distance,
                   number(rule.photo_scale), hn::Mul(prior_scale, number(kPixel * kPixel))},
      number);
  const F within = Clamped(step, number(-kMaxStep - 1.0F), number(kMaxStep));
  // Rounded to nearest: a float of so large a number has no bits left for fractions.
  const F large = number(3 << 22);
  const V steps = hn::Sub(hn::BitCast(d, hn::Add(within, large)), hn::BitCast(d, large));
  return hn::IfThenElseZero(hn::AndNot(missing, is_least), steps);
}

// Neighbouring pixels of a band's table, as many as D, a tag of int32_t, has lanes.
template <class D>
class LeftPixels {
 public:
  using V = hn::Vec<D>;

  HWY_INLINE LeftPixels(V sigmas, V priors, V disparities)
      : numbers_(sigmas),
        places_(hn::Or(hn::And(priors, hn::Set(D(), 0xffff)), hn::ShiftLeft<16>(disparities))) {}

  HWY_INLINE void Store(LeftPixel* first) const {
    Memory memory;
    hn::StoreInterleaved2(numbers_, places_, D(), memory.data());
    std::memcpy(static_cast<void*>(first), memory.data(), sizeof(Memory));
  }

 private:
  // A pixel is two numbers: σ or a link, and prior with the disparity above it.
  static_assert(sizeof(LeftPixel) == 2 * sizeof(int32_t) &&
                std::endian::native == std::endian::little);
  using Memory = std::array<int32_t, 2 * hn::MaxLanes(D())>;

  V numbers_, places_;
};

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
