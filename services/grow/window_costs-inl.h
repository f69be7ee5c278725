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

// Eq. (5). @param distances  from the prior, counts.
template <class V>
HWY_INLINE FloatsOf<V> PriorCosts(const GrowthRule& rule, V distances) {
  const hn::RebindToFloat<hn::DFromV<V>> df;
  const auto f = hn::ConvertTo(df, distances);
  return hn::Mul(hn::Mul(f, f), hn::Set(df, rule.prior_scale));
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

// Σ wL·wR over 5×5 windows with the right ones of d + 1, d, d − 1, d − 2.
HWY_INLINE Four CrossSums(const GrowthRow& row, int u, int d) {
  constexpr int kColumn = GrowthBand::kColumnRows;
  const int16_t* left = row.left_columns + (u - kWindowRadius) * kColumn;
  const int16_t* right = row.right_columns + (u - (d + 1) - kWindowRadius) * kColumn;
  Four sums{};
  for (size_t i = 0; i < 4; ++i, right += kColumn) {
    for (int k = 0; k < kWindow * kColumn; ++k) {
      sums[i] += (left[k] & row.window_rows[k % kColumn]) * right[k];
    }
  }
  return sums;
}

// Costs of d + 1, d, d − 1 and d − 2 at a pixel.
template <GrowConfig::Similarity kSimilarity>
Four FourCosts(const GrowthRule& rule, const GrowthRow& row, int u, int d) {
  const LeftPixel& pixel = row.left[u];
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
    auto cost = PhotoCosts<kSimilarity>(rule, one(pixel.energy + right[at]), one(cross[at]));
    if constexpr (kSimilarity == GrowConfig::EPC) {
      const int distance = disparity * DisparityImage::kCountsPerPixel - pixel.prior;
      cost = hn::Add(cost, PriorCosts(rule, one(distance)));
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

// Half of the way to the sums of a's and of b's lanes.
template <class V>
HWY_INLINE V AddInterleaved(V a, V b) {
  const hn::DFromV<V> d;
  return hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));
}

template <class V>
HWY_INLINE auto AddHalves(V a) {
  const hn::Half<hn::DFromV<V>> d;
  return AddInterleaved(hn::LowerHalf(d, a), hn::UpperHalf(d, a));
}

// Sums of the products of a left window with right ones that begin at four columns in a row.
template <int kRegisters>
struct WindowSums;

// One right window in a register.
template <>
struct WindowSums<4> {
  template <class V>
  static HWY_INLINE Four Of(const V (&sums)[4]) {
    return AddInterleaved(AddInterleaved(sums[0], sums[2]), AddInterleaved(sums[1], sums[3]));
  }
};

// Two.
template <>
struct WindowSums<2> {
  template <class V>
  static HWY_INLINE Four Of(const V (&sums)[2]) {
    return AddHalves(AddInterleaved(sums[0], sums[1]));
  }
};

// Four.
template <>
struct WindowSums<1> {
  template <class V>
  static HWY_INLINE Four Of(const V (&sums)[1]) {
    return AddHalves(AddHalves(sums[0]));
  }
};

// Σ wL·wR over 5×5 windows with the right ones of d + 1, d, d − 1, d − 2.
HWY_INLINE Four CrossSums(const GrowthRow& row, int u, int d) {
  constexpr int kColumn = GrowthBand::kColumnRows;
  const int16_t* HWY_RESTRICT left = row.left_columns + (u - kWindowRadius) * kColumn;
  const int16_t* HWY_RESTRICT right = row.right_columns + (u - (d + 1) - kWindowRadius) * kColumn;
  const hn::CappedTag<int16_t, 4 * kColumn> d16;
  const hn::RepartitionToWide<decltype(d16)> d32;
  constexpr int kStep = static_cast<int>(hn::MaxLanes(d16));
  constexpr int kRegisters = 4 * kColumn / kStep;
  const auto in_window = hn::LoadDup128(d16, row.window_rows);
  hn::Vec<decltype(d32)> sums[kRegisters];
  hn::Vec<decltype(d32)> rests[kRegisters];  // where products are not added in pairs
  for (int i = 0; i < kRegisters; ++i) sums[i] = rests[i] = hn::Zero(d32);
  HWY_UNROLL(5)
  for (int x = 0; x < kWindow; ++x, left += kColumn, right += kColumn) {
    const auto l = hn::And(hn::LoadDup128(d16, left), in_window);
    for (int i = 0; i < kRegisters; ++i) {
      sums[i] = hn::ReorderWidenMulAccumulate(d32, l, hn::LoadU(d16, right + i * kStep), sums[i],
                                              rests[i]);
    }
  }
  for (int i = 0; i < kRegisters; ++i) sums[i] = hn::Add(sums[i], rests[i]);
  return WindowSums<kRegisters>::Of(sums);
}

// Σ wR² of the same windows; GrowthBand::kOutside where one does not fit.
HWY_INLINE Four RightEnergies(const GrowthRow& row, int u, int d) {
  return hn::LoadU(DFour(), row.right_energy + (u - (d + 1)));
}

// Costs of d + 1, d, d − 1 and d − 2 at a pixel.
template <GrowConfig::Similarity kSimilarity>
HWY_INLINE Four FourCosts(const GrowthRule& rule, const GrowthRow& row, int u, int d) {
  const DFour d4;
  const LeftPixel& pixel = row.left[u];
  const Four right = RightEnergies(row, u, d);
  const Four disparities = hn::Add(hn::Set(d4, d), LoadFour({1, 0, -1, -2}));
  Four cross = CrossSums(row, u, d);
  if constexpr (kSimilarity == GrowConfig::MNCC) {
    const hn::FixedTag<uint16_t, 4> d_u16;
    const Four right_sums = hn::PromoteTo(d4, hn::LoadU(d_u16, row.right_sum + (u - (d + 1))));
    cross = hn::Sub(hn::Mul(hn::Set(d4, kWindow * kWindow), cross),
                    hn::Mul(hn::Set(d4, row.left_sum[u]), right_sums));
  }
  auto cost = PhotoCosts<kSimilarity>(rule, hn::Add(hn::Set(d4, pixel.energy), right), cross);
  if constexpr (kSimilarity == GrowConfig::EPC) {  // eq. (6)
    static_assert(DisparityImage::kCountsPerPixel == 1 << 5);
    const Four distances = hn::Sub(hn::ShiftLeft<5>(disparities), hn::Set(d4, pixel.prior));
    cost = hn::Add(cost, PriorCosts(rule, distances));
  }
  return WholeCosts(cost, right, disparities);
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
