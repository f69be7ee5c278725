// Costs of four disparities at once, for each instruction set: included by growth.cc, which
// Highway compiles once for each. No include guard of the usual kind for that reason.
#if defined(SPROUT_SERVICES_GROW_WINDOW_COSTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SPROUT_SERVICES_GROW_WINDOW_COSTS_INL_H_
#undef SPROUT_SERVICES_GROW_WINDOW_COSTS_INL_H_
#else
#define SPROUT_SERVICES_GROW_WINDOW_COSTS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>

#include "services/grow/growth_band.h"

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

// Numbers of the disparities d + 1, d, d − 1 and d − 2, in this order: so the right windows lie in
// memory.
using FourNumbers = std::array<int32_t, 4>;

namespace hn = hwy::HWY_NAMESPACE;

template <class V>
using FloatsOf = hn::Vec<hn::RebindToFloat<hn::DFromV<V>>>;

// Eq. (4) as a cost, not yet whole: Σ (wL − wR)² / (σ_s² · Σ (wL² + wR²)). With MNCC eq. (1), whose
// sums have the same form: 1 − 2·cov / (var + var), everything times n⁴.
// @param energies  Σ wL² + Σ wR². @param cross  Σ wL·wR.
template <GrowConfig::Similarity kSimilarity, class V>
HWY_INLINE FloatsOf<V> PhotoCosts(const GrowthRule& rule, V energies, V cross) {
  const hn::DFromV<V> d;
  const hn::RebindToFloat<decltype(d)> df;
  // Without variance no correlation; without energy no difference.
  const V divisor = hn::Max(energies, hn::Set(d, 1));
  const V total = kSimilarity == GrowConfig::MNCC ? divisor : energies;
  const auto scale = hn::Div(hn::Set(df, rule.photo_scale), hn::ConvertTo(df, divisor));
  return hn::Mul(hn::ConvertTo(df, hn::Sub(hn::Sub(total, cross), cross)), scale);
}

// Eq. (5). @param distances  from the prior, counts. @param scale  of GrowthRule::prior_scales.
template <class V>
HWY_INLINE FloatsOf<V> PriorCosts(float scale, V distances) {
  const hn::RebindToFloat<hn::DFromV<V>> df;
  const auto f = hn::ConvertTo(df, distances);
  return hn::Mul(hn::Mul(f, f), hn::Set(df, scale));
}

// Whole costs, kExcludedCost where a window does not fit. Costs beyond every limit saturate.
template <class V>
HWY_INLINE V WholeCosts(FloatsOf<V> costs, V right_energies, V disparities) {
  const hn::DFromV<V> d;
  const hn::RebindToFloat<decltype(d)> df;
  const V whole = hn::ConvertTo(d, hn::Min(costs, hn::Set(df, kLargestCost)));
  const auto misfit = hn::Lt(hn::Or(right_energies, disparities), hn::Zero(d));
  return hn::IfThenElse(misfit, hn::Set(d, kExcludedCost), whole);
}

#if HWY_TARGET == HWY_SCALAR  // what every CPU can do: one number at a time

using Four = FourNumbers;

HWY_INLINE FourNumbers ToNumbers(const Four& four) { return four; }

// The smallest of (cost << 2 | place) of the first three, with a place for each.
HWY_INLINE int32_t SmallestKey(const Four& costs, const std::array<int32_t, 3>& places) {
  int32_t smallest = INT32_MAX;
  for (size_t i = 0; i < 3; ++i) smallest = std::min(smallest, costs[i] << 2 | places[i]);
  return smallest;
}

HWY_INLINE Four RightEnergies(const GrowthRow& row, int u, int d) {
  Four energies;
  std::copy_n(row.right_energy + (u - (d + 1)), 4, energies.data());
  return energies;
}

// Σ wL·wR over a 5×5 window with the right one of d.
inline int32_t CrossSum(const GrowthRow& row, int u, int d) {
  int32_t sum = 0;
  for (size_t i = 0; i < row.left_pairs.size(); ++i) {
    const int32_t in_window = i < 2 ? -1 : 0xffff;
    for (int x = u - kWindowRadius; x <= u + kWindowRadius; ++x) {
      const int32_t left = row.left_pairs[i][x] & in_window;
      const int32_t right = row.right_pairs[i][x - d];
      sum += (left & 0xffff) * (right & 0xffff) + (left >> 16) * (right >> 16);
    }
  }
  return sum;
}

// With the right ones of d + 1, d, d − 1, d − 2.
HWY_INLINE Four CrossSums(const GrowthRow& row, int u, int d) {
  return {CrossSum(row, u, d + 1), CrossSum(row, u, d), CrossSum(row, u, d - 1),
          CrossSum(row, u, d - 2)};
}

// As the same class below: one pixel.
template <class D>
class LeftRun {
 public:
  LeftRun(const GrowthRow& row, int u) : row_(row), u_(u) {}
  hn::Vec<D> CrossSums(int d) const { return hn::Set(D(), CrossSum(row_, u_, d)); }

 private:
  const GrowthRow& row_;
  int u_;
};

// Costs of d + 1, d, d − 1 and d − 2 at a pixel.
template <GrowConfig::Similarity kSimilarity>
Four FourCosts(const GrowthRule& rule, const GrowthRow& row, int u, int d) {
  const auto one = [](int32_t number) { return hn::Set(hn::CappedTag<int32_t, 1>(), number); };
  const Four right = RightEnergies(row, u, d);
  Four cross = CrossSums(row, u, d);
  Four costs;
  for (int i = 0; i < 4; ++i) {
    const auto at = static_cast<size_t>(i);
    const int disparity = d + 1 - i;
    if constexpr (kSimilarity == GrowConfig::MNCC) {
      cross[at] = kWindow * kWindow * cross[at] - row.left_sum[u] * row.right_sum[u - disparity];
    }
    if (right[at] < 0) {
      costs[at] = kExcludedCost;
      continue;
    }
    auto cost = PhotoCosts<kSimilarity>(rule, one(row.left_energy[u] + right[at]), one(cross[at]));
    if constexpr (kSimilarity == GrowConfig::EPC) {
      const int distance = disparity * DisparityImage::kCountsPerPixel - row.left[u].prior;
      cost = hn::Add(cost, PriorCosts(rule.prior_scales[row.sigma[u]], one(distance)));
    }
    costs[at] = hn::GetLane(WholeCosts(cost, one(right[at]), one(disparity)));
  }
  return costs;
}

#else

using DFour = hn::FixedTag<int32_t, 4>;
using Four = hn::Vec<DFour>;

HWY_INLINE Four LoadFour(const FourNumbers& numbers) { return hn::LoadU(DFour(), numbers.data()); }

HWY_INLINE FourNumbers ToNumbers(Four four) {
  FourNumbers numbers;
  hn::StoreU(four, DFour(), numbers.data());
  return numbers;
}

HWY_INLINE int32_t SmallestKey(Four costs, const std::array<int32_t, 3>& places) {
  const Four last = LoadFour({places[0], places[1], places[2], INT32_MAX});
  const auto keys = hn::Or(hn::ShiftLeft<2>(costs), last);
  return hn::GetLane(hn::MinOfLanes(DFour(), keys));
}

// Pairs of two windows: the products of the upper and of the lower pixels, added.
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

// Pairs of left columns, of which products with right ones give sums over columns of a window.
template <class D>
class LeftColumns {
 public:
  using V = hn::Vec<D>;

  // @param u  the first column; as many as there are lanes.
  HWY_INLINE LeftColumns(const GrowthRow& row, int u)
      : pairs_{Load(row, 0, u), Load(row, 1, u), hn::And(Load(row, 2, u), hn::Set(D(), 0xffff))} {}

  // Σ wL·wR over each column. @param u  the right column that belongs to the first one.
  HWY_INLINE V CrossSums(const GrowthRow& row, int u) const {
    const auto sums = [&](size_t i) HWY_ATTR {
      return PairProducts(pairs_[i], hn::LoadU(D(), row.right_pairs[i] + u));
    };
    return hn::Add(hn::Add(sums(0), sums(1)), sums(2));
  }

 private:
  static HWY_INLINE V Load(const GrowthRow& row, size_t i, int u) {
    return hn::LoadU(D(), row.left_pairs[i] + u);
  }

  V pairs_[3];
};

// Σ wL·wR over 5×5 windows with the right ones of d + 1, d, d − 1, d − 2.
HWY_INLINE Four CrossSums(const GrowthRow& row, int u, int d) {
  const DFour d4;
  const auto row_sums = [&](size_t i, Four in_window) HWY_ATTR {
    const int32_t* HWY_RESTRICT left = row.left_pairs[i] + (u - kWindowRadius);
    const int32_t* HWY_RESTRICT right = row.right_pairs[i] + (u - (d + 1) - kWindowRadius);
    Four sums = hn::Zero(d4);
    HWY_UNROLL(5)
    for (int x = 0; x < kWindow; ++x) {
      const Four pairs = hn::And(hn::Set(d4, left[x]), in_window);
      sums = hn::Add(sums, PairProducts(pairs, hn::LoadU(d4, right + x)));
    }
    return sums;
  };
  const Four both = hn::Set(d4, -1);
  return hn::Add(hn::Add(row_sums(0, both), row_sums(1, both)), row_sums(2, hn::Set(d4, 0xffff)));
}

// The left windows of neighbouring pixels, as many as D has lanes.
template <class D>
class LeftRun {
 public:
  using V = hn::Vec<D>;

  // @param u  the first pixel.
  HWY_INLINE LeftRun(const GrowthRow& row, int u)
      : row_(row),
        first_(u - kWindowRadius),
        columns_(row, first_),
        last_columns_(row, first_ + kLanes) {}

  // Σ wL·wR over each window with the right one of d. Reads as many columns whether they fit or
  // not.
  HWY_INLINE V CrossSums(int d) const {
    const D tag;
    const V columns = columns_.CrossSums(row_, first_ - d);
    const V behind = FourOn(columns, last_columns_.CrossSums(row_, first_ + kLanes - d));
    const V two = hn::Add(columns, hn::CombineShiftRightLanes<1>(tag, behind, columns));
    const V three = hn::Add(two, hn::CombineShiftRightLanes<2>(tag, behind, columns));
    return hn::Add(hn::Add(three, hn::CombineShiftRightLanes<3>(tag, behind, columns)), behind);
  }

 private:
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));

  // What lies four lanes on. @param last  follows on the last lane.
  static HWY_INLINE V FourOn(V columns, Four last) {
    if constexpr (kLanes == 4) {
      return last;
    } else {
      alignas(16) int32_t numbers[4];
      hn::Store(last, DFour(), numbers);
      static constexpr auto kFourOn = [] {
        std::array<int32_t, kLanes> lanes{};
        for (int lane = 0; lane < kLanes; ++lane) {
          lanes[static_cast<size_t>(lane)] = (lane + 4) % kLanes;
        }
        return lanes;
      }();
      return hn::IfThenElse(hn::FirstN(D(), kLanes - 4),
                            hn::TableLookupLanes(columns, hn::SetTableIndices(D(), kFourOn.data())),
                            hn::LoadDup128(D(), numbers));
    }
  }

  const GrowthRow& row_;
  int first_;
  LeftColumns<D> columns_;
  LeftColumns<DFour> last_columns_;
};

// Σ wR² of the same windows; GrowthBand::kOutside where one does not fit.
HWY_INLINE Four RightEnergies(const GrowthRow& row, int u, int d) {
  return hn::LoadU(DFour(), row.right_energy + (u - (d + 1)));
}

// Costs of d + 1, d, d − 1 and d − 2 at a pixel.
template <GrowConfig::Similarity kSimilarity>
HWY_INLINE Four FourCosts(const GrowthRule& rule, const GrowthRow& row, int u, int d) {
  const DFour d4;
  const Four right = RightEnergies(row, u, d);
  const Four disparities = hn::Add(hn::Set(d4, d), LoadFour({1, 0, -1, -2}));
  Four cross = CrossSums(row, u, d);
  if constexpr (kSimilarity == GrowConfig::MNCC) {
    const hn::FixedTag<uint16_t, 4> d_u16;
    const Four right_sums = hn::PromoteTo(d4, hn::LoadU(d_u16, row.right_sum + (u - (d + 1))));
    cross = hn::Sub(hn::Mul(hn::Set(d4, kWindow * kWindow), cross),
                    hn::Mul(hn::Set(d4, row.left_sum[u]), right_sums));
  }
  auto cost = PhotoCosts<kSimilarity>(rule, hn::Add(hn::Set(d4, row.left_energy[u]), right), cross);
  if constexpr (kSimilarity == GrowConfig::EPC) {  // eq. (6)
    static_assert(DisparityImage::kCountsPerPixel == 1 << 5);
    const Four distances = hn::Sub(hn::ShiftLeft<5>(disparities), hn::Set(d4, row.left[u].prior));
    cost = hn::Add(cost, PriorCosts(rule.prior_scales[row.sigma[u]], distances));
  }
  return WholeCosts(cost, right, disparities);
}

#endif  // HWY_TARGET == HWY_SCALAR

// Where between d − 1 and d + 1 the parabola through their costs has its minimum, from d, counts;
// none where a cost is missing or d is not better than the two others.
template <class V>
HWY_INLINE V StepsToMinimum(V minus_one, V cost, V plus_one) {
  const hn::DFromV<V> d;
  const hn::RebindToFloat<decltype(d)> df;
  const V before = hn::Sub(minus_one, cost);
  const V behind = hn::Sub(plus_one, cost);
  const V sum = hn::Add(before, behind);
  const auto missing = hn::Eq(hn::Max(minus_one, plus_one), hn::Set(d, kExcludedCost));
  const auto none = hn::Or(missing, hn::Lt(hn::Min(before, behind), hn::Set(d, 1)));
  // Half a pixel times (before − behind) / (before + behind), rounded to nearest: a float of so
  // large a number has no bits left for fractions.
  constexpr float kHalf = DisparityImage::kCountsPerPixel / 2;
  const auto difference = hn::IfThenZeroElse(none, hn::Sub(before, behind));
  const auto divisor = hn::Max(sum, hn::Set(d, 1));
  const auto step = hn::Div(hn::Mul(hn::Set(df, kHalf), hn::ConvertTo(df, difference)),
                            hn::ConvertTo(df, divisor));
  const auto large = hn::Set(df, 3 << 22);
  return hn::Sub(hn::BitCast(d, hn::Add(step, large)), hn::BitCast(d, large));
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
