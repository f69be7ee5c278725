// Costs of three disparities at once, for each instruction set: included by growth.cc, which
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
// memory. The fourth is of no use; registers have room for it.
using FourNumbers = std::array<int32_t, 4>;

#if HWY_TARGET == HWY_SCALAR  // what every CPU can do: one number at a time

using Four = FourNumbers;

template <GrowConfig::Similarity kSimilarity>
Four FourCosts(const GrowthRule& rule, const GrowthRow& row, int u, int d) {
  constexpr int kColumn = GrowthBand::kColumnRows;
  const LeftPixel& pixel = row.left[u];
  Four costs;
  costs.fill(kExcludedCost);
  for (int i = 0; i < 3; ++i) {
    const int disparity = d + 1 - i;
    const int32_t right_energy = row.right_energy[u - disparity];
    if (right_energy < 0 || disparity < 0) continue;
    const int16_t* left = row.left_columns + (u - kWindowRadius) * kColumn;
    const int16_t* right = row.right_columns + (u - disparity - kWindowRadius) * kColumn;
    int32_t cross = 0;  // Σ wL·wR
    for (int k = 0; k < kWindow * kColumn; ++k) {
      cross += (left[k] & row.window_rows[k % kColumn]) * right[k];
    }
    const int32_t energies = pixel.energy + right_energy;
    const float scale = rule.photo_scale / static_cast<float>(std::max(energies, 1));
    int32_t difference = energies - 2 * cross;
    if constexpr (kSimilarity == GrowConfig::MNCC) {
      difference = std::max(energies, 1) -
                   2 * (kWindow * kWindow * cross - row.left_sum[u] * row.right_sum[u - disparity]);
    }
    float cost = static_cast<float>(difference) * scale;
    if constexpr (kSimilarity == GrowConfig::EPC) {
      const int distance = disparity * DisparityImage::kCountsPerPixel - pixel.prior;
      cost += PriorCost(distance, rule.prior_scale);
    }
    costs[static_cast<size_t>(i)] = static_cast<int32_t>(std::min(cost, kLargestCost));
  }
  return costs;
}

HWY_INLINE FourNumbers ToNumbers(const Four& four) { return four; }

// The smallest of (cost << 2 | place), with a place for each.
HWY_INLINE int32_t SmallestKey(const Four& costs, const FourNumbers& places) {
  int32_t smallest = INT32_MAX;
  for (size_t i = 0; i < 4; ++i) smallest = std::min(smallest, costs[i] << 2 | places[i]);
  return smallest;
}

#else

namespace hn = hwy::HWY_NAMESPACE;

using DFour = hn::FixedTag<int32_t, 4>;
using Four = hn::Vec<DFour>;

HWY_INLINE Four LoadFour(const FourNumbers& numbers) { return hn::LoadU(DFour(), numbers.data()); }

HWY_INLINE FourNumbers ToNumbers(Four four) {
  FourNumbers numbers;
  hn::StoreU(four, DFour(), numbers.data());
  return numbers;
}

HWY_INLINE int32_t SmallestKey(Four costs, const FourNumbers& places) {
  const auto keys = hn::Or(hn::ShiftLeft<2>(costs), LoadFour(places));
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
  const hn::Half<hn::DFromV<V> > d;
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

// Costs of d + 1, d and d − 1 at a pixel; kExcludedCost where a window does not fit. Costs beyond
// every limit saturate.
template <GrowConfig::Similarity kSimilarity>
HWY_INLINE Four FourCosts(const GrowthRule& rule, const GrowthRow& row, int u, int d) {
  const DFour d4;
  const hn::FixedTag<float, 4> df;
  const LeftPixel& pixel = row.left[u];
  const Four right = hn::LoadU(d4, row.right_energy + (u - (d + 1)));
  const Four disparities = hn::Add(hn::Set(d4, d), LoadFour({1, 0, -1, -2}));
  const Four energies = hn::Add(hn::Set(d4, pixel.energy), right);
  const Four divisor = hn::Max(energies, hn::Set(d4, 1));
  const auto scale = hn::Div(hn::Set(df, rule.photo_scale), hn::ConvertTo(df, divisor));
  const Four cross = CrossSums(row, u, d);

  auto cost = hn::Zero(df);
  if constexpr (kSimilarity == GrowConfig::MNCC) {
    // Eq. (1): 1 − 2·cov / (var + var), everything times n⁴. Without variance no correlation.
    const hn::FixedTag<uint16_t, 4> d_u16;
    const Four right_sums = hn::PromoteTo(d4, hn::LoadU(d_u16, row.right_sum + (u - (d + 1))));
    const Four covariance = hn::Sub(hn::Mul(hn::Set(d4, kWindow * kWindow), cross),
                                    hn::Mul(hn::Set(d4, row.left_sum[u]), right_sums));
    const Four difference = hn::Sub(divisor, hn::Add(covariance, covariance));
    cost = hn::Mul(hn::ConvertTo(df, difference), scale);
  } else {
    // Eq. (4): Σ (wL − wR)² / (σ_s² · Σ (wL² + wR²)).
    const Four difference = hn::Sub(hn::Sub(energies, cross), cross);
    cost = hn::Mul(hn::ConvertTo(df, difference), scale);
    if constexpr (kSimilarity == GrowConfig::EPC) {  // Eqs. (5) and (6)
      constexpr int kOne = DisparityImage::kCountsPerPixel;
      static_assert(kOne == 1 << 5);
      const Four distance = hn::Sub(hn::ShiftLeft<5>(disparities), hn::Set(d4, pixel.prior));
      const auto f = hn::ConvertTo(df, distance);
      cost = hn::Add(cost, hn::Mul(hn::Mul(f, f), hn::Set(df, rule.prior_scale)));
    }
  }
  const Four whole = hn::ConvertTo(d4, hn::Min(cost, hn::Set(df, kLargestCost)));
  const Four misfit = hn::Or(hn::Or(right, disparities), LoadFour({0, 0, 0, INT32_MIN}));
  return hn::IfThenElse(hn::Lt(misfit, hn::Zero(d4)), hn::Set(d4, kExcludedCost), whole);
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
