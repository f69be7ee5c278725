// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include "common/core/median.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "common/core/median.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef SPROUT_COMMON_CORE_MEDIAN_SHARED_
#define SPROUT_COMMON_CORE_MEDIAN_SHARED_
namespace sprout {
namespace {

constexpr int kSide = 5;
constexpr int kRadius = kSide / 2;

using Rows = std::array<const int16_t*, kSide>;

struct Comparator {
  uint8_t less, more;
};
constexpr Comparator kSort[] = {{0, 1}, {3, 4}, {2, 4}, {2, 3}, {0, 3},
                                {0, 2}, {1, 4}, {1, 3}, {1, 2}};
// The median of five sorted columns, 0 to 4 their least values: sorts what matters of each rank,
// then what is left. Found by leaving out what no order of 0 and 1 needs. The last comparator's
// greater one is the median.
constexpr Comparator kSelect[] = {
    {0, 1},   {3, 4},   {2, 4},   {2, 3},   {0, 3},   {1, 4},   {1, 3},   {5, 8},
    {6, 9},   {6, 8},   {5, 6},   {7, 9},   {6, 7},   {8, 9},   {7, 8},   {10, 13},
    {11, 14}, {10, 12}, {11, 13}, {10, 11}, {12, 14}, {11, 12}, {13, 14}, {12, 13},
    {16, 19}, {15, 17}, {16, 18}, {15, 16}, {17, 19}, {16, 17}, {17, 18}, {20, 21},
    {23, 24}, {22, 23}, {20, 23}, {20, 22}, {21, 24}, {21, 22}, {15, 3},  {11, 7},
    {4, 12},  {20, 8},  {9, 17},  {3, 7},   {4, 20},  {12, 8},  {16, 9},  {12, 20},
    {16, 13}, {7, 12},  {12, 20}, {21, 9},  {12, 21}, {7, 12},  {20, 16}, {12, 20}};
constexpr size_t kMedian = 20;
// The same for the lower half, from the least to the median.
constexpr Comparator kOrder[] = {
    {0, 3},   {5, 8},   {10, 13}, {15, 18}, {20, 23}, {20, 3},  {10, 20}, {15, 8},  {13, 3},
    {5, 10},  {15, 20}, {8, 13},  {18, 3},  {2, 4},   {7, 9},   {12, 14}, {17, 19}, {22, 24},
    {1, 0},   {6, 5},   {11, 10}, {16, 15}, {21, 20}, {3, 0},   {23, 5},  {22, 4},  {21, 3},
    {8, 23},  {13, 10}, {18, 15}, {20, 0},  {12, 22}, {17, 9},  {14, 4},  {11, 21}, {16, 8},
    {13, 3},  {18, 23}, {10, 20}, {15, 5},  {7, 12},  {17, 22}, {9, 14},  {19, 4},  {6, 11},
    {16, 21}, {8, 13},  {18, 3},  {23, 10}, {15, 20}, {2, 1},   {7, 6},   {12, 11}, {17, 16},
    {22, 21}, {9, 8},   {14, 13}, {19, 18}, {4, 3},   {24, 23}, {4, 1},   {24, 6},  {10, 11},
    {15, 16}, {20, 21}, {5, 8},   {22, 4},  {9, 24},  {14, 10}, {19, 15}, {20, 1},  {5, 6},
    {12, 22}, {17, 9},  {14, 4},  {19, 24}, {10, 20}, {15, 5},  {7, 12},  {17, 22}, {9, 14},
    {19, 4},  {24, 10}, {15, 20}};
constexpr size_t kOrdered[] = {2, 7, 12, 17, 22, 9, 14, 19, 4, 24, 10, 15, 20};

constexpr int16_t kGap = DisparityImage::kInvalid;
static_assert(kGap == INT16_MIN);

}  // namespace
}  // namespace sprout
#endif  // once

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class V>
HWY_INLINE void Compare(V& less, V& more) {
  const V least = hn::Min(less, more);
  more = hn::Max(less, more);
  less = least;
}

// Written out by the compiler, so that values stay in registers and unused ones are left out.
template <const auto& kComparators, class V, size_t... kIndex>
HWY_INLINE void CompareAll(V* values, std::index_sequence<kIndex...>) {
  (Compare(values[kComparators[kIndex].less], values[kComparators[kIndex].more]), ...);
}
template <const auto& kComparators, class V>
HWY_INLINE void CompareAll(V* values) {
  CompareAll<kComparators>(values, std::make_index_sequence<std::size(kComparators)>());
}

// The value of a rank.
template <class D, class V, size_t... kIndex>
HWY_INLINE V Ranked(D d, const V* window, V rank, std::index_sequence<kIndex...>) {
  V value = window[kOrdered[0]];
  ((value = hn::IfThenElse(hn::Eq(rank, hn::Set(d, static_cast<int16_t>(kIndex))),
                           window[kOrdered[kIndex]], value)),
   ...);
  return value;
}

// Medians of the numbers that are no gaps, at gaps only.
// @param window  numbers less 1, so that gaps are the greatest. @param gaps  how many are gaps.
template <class D, class V>
HWY_INLINE V MedianOfKnown(D d, V* window, V gaps) {
  CompareAll<kOrder>(window);
  const V rank = hn::ShiftRight<1>(hn::Sub(hn::Set(d, kSide * kSide - 1), gaps));
  const V median = Ranked(d, window, rank, std::make_index_sequence<std::size(kOrdered)>());
  return hn::Add(median, hn::Set(d, 1));
}

// @param kFill   whether only gaps are filled.
// @param rows    around the one that is written.
// @param memory  for the sorted columns, ranks one behind the other, then their numbers of gaps.
template <bool kFill, class D>
void FilterRow(D d, const Rows& rows, int width, int16_t* memory, int16_t* to) {
  using V = hn::Vec<D>;
  constexpr auto kLanes = static_cast<int>(hn::MaxLanes(D()));
  const int stride = width + 2 * kRadius;
  int16_t* const gaps = memory + kSide * stride;
  const auto for_each = [&](const auto& act) HWY_ATTR {
    for (int u = 0; u < width; u += kLanes) act(std::min(u, width - kLanes));
  };
  for_each([&](int u) HWY_ATTR {
    V column[kSide];
    V gaps_here = hn::Zero(d);
    for (size_t y = 0; y < kSide; ++y) {
      column[y] = hn::LoadU(d, rows[y] + u);
      if constexpr (!kFill) continue;
      gaps_here = hn::Sub(gaps_here, hn::VecFromMask(d, hn::Eq(column[y], hn::Set(d, kGap))));
      column[y] = hn::Sub(column[y], hn::Set(d, 1));
    }
    CompareAll<kSort>(column);
    for (int y = 0; y < kSide; ++y) hn::StoreU(column[y], d, memory + y * stride + kRadius + u);
    if constexpr (kFill) hn::StoreU(gaps_here, d, gaps + kRadius + u);
  });
  const auto set_border = [&](int16_t* rank, int16_t left, int16_t right) {
    std::fill_n(rank, kRadius, left);
    std::fill_n(rank + kRadius + width, kRadius, right);
  };
  for (int16_t* rank = memory; rank < gaps; rank += stride) {
    if constexpr (kFill) set_border(rank, INT16_MAX, INT16_MAX);
    if constexpr (!kFill) set_border(rank, rank[kRadius], rank[kRadius + width - 1]);
  }
  if constexpr (kFill) set_border(gaps, kSide, kSide);
  for_each([&](int u) HWY_ATTR {
    const V here = hn::LoadU(d, rows[kRadius] + u);
    const auto is_gap = hn::Eq(here, hn::Set(d, kGap));
    if (kFill && hn::AllFalse(d, is_gap)) return hn::StoreU(here, d, to + u);
    V window[kSide * kSide];
    HWY_UNROLL(25)
    for (int i = 0; i < kSide * kSide; ++i) {
      window[i] = hn::LoadU(d, memory + i / kSide * stride + u + i % kSide);
    }
    if constexpr (kFill) {
      V sum = hn::LoadU(d, gaps + u);
      for (int x = 1; x < kSide; ++x) sum = hn::Add(sum, hn::LoadU(d, gaps + u + x));
      hn::StoreU(hn::IfThenElse(is_gap, MedianOfKnown(d, window, sum), here), d, to + u);
    } else {
      CompareAll<kSelect>(window);
      hn::StoreU(window[kMedian], d, to + u);
    }
  });
}

template <bool kFill>
HWY_INLINE void AnyRow(const Rows& rows, int width, int16_t* memory, int16_t* to) {
  const hn::CappedTag<int16_t, 32> d;
  if (width < static_cast<int>(hn::MaxLanes(d))) {
    return FilterRow<kFill>(hn::CappedTag<int16_t, 1>(), rows, width, memory, to);
  }
  FilterRow<kFill>(d, rows, width, memory, to);
}

void FilterRowOnTarget(bool fill, const Rows& rows, int width, int16_t* memory, int16_t* to) {
  fill ? AnyRow<true>(rows, width, memory, to) : AnyRow<false>(rows, width, memory, to);
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout {

HWY_EXPORT(FilterRowOnTarget);

static void Filter(bool fill, const cv::Mat1s& from, cv::Mat1s& to) {
  const std::vector<int16_t> no_row(static_cast<size_t>(fill ? from.cols : 0), kGap);
  ForRangesParallel(from.rows, from.rows, [&](const cv::Range& range) {
    std::vector<int16_t> memory(static_cast<size_t>((kSide + 1) * (from.cols + 2 * kRadius)));
    for (int v = range.start; v < range.end; ++v) {
      Rows rows;
      for (int y = 0; y < kSide; ++y) {
        const int wanted = v + y - kRadius;
        const int nearest = std::clamp(wanted, 0, from.rows - 1);
        rows[static_cast<size_t>(y)] = fill && wanted != nearest ? no_row.data() : from[nearest];
      }
      HWY_DYNAMIC_DISPATCH(FilterRowOnTarget)(fill, rows, from.cols, memory.data(), to[v]);
    }
  });
}

void FilterByMedian(const cv::Mat1s& from, cv::Mat1s& to) { Filter(false, from, to); }

void FillByMedian(const DisparityImage& from, DisparityImage& to) {
  Filter(true, from.counts(), to.counts());
}

}  // namespace sprout
#endif  // HWY_ONCE
