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

}  // namespace
}  // namespace sprout
#endif  // once

HWY_BEFORE_NAMESPACE();
namespace sprout {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Written out by the compiler, so that values stay in registers and unused ones are left out.
template <const auto& kComparators, class V, size_t... kIndex>
HWY_INLINE void Compare(V* values, std::index_sequence<kIndex...>) {
  const auto compare = [&](const Comparator& at) HWY_ATTR {
    const V less = hn::Min(values[at.less], values[at.more]);
    values[at.more] = hn::Max(values[at.less], values[at.more]);
    values[at.less] = less;
  };
  (compare(kComparators[kIndex]), ...);
}

// @param rows    around the one that is written.
// @param sorted  memory for the columns, ranks one behind the other.
template <class D>
void FilterRow(D d, const std::array<const int16_t*, kSide>& rows, int width, int16_t* sorted,
               int16_t* to) {
  using V = hn::Vec<D>;
  constexpr auto kLanes = static_cast<int>(hn::MaxLanes(D()));
  const int stride = width + 2 * kRadius;
  const auto for_each = [&](const auto& act) HWY_ATTR {
    for (int u = 0; u < width; u += kLanes) act(std::min(u, width - kLanes));
  };
  for_each([&](int u) HWY_ATTR {
    V column[kSide];
    for (size_t y = 0; y < kSide; ++y) column[y] = hn::LoadU(d, rows[y] + u);
    Compare<kSort>(column, std::make_index_sequence<std::size(kSort)>());
    for (int y = 0; y < kSide; ++y) hn::StoreU(column[y], d, sorted + y * stride + kRadius + u);
  });
  for (int16_t* rank = sorted; rank < sorted + kSide * stride; rank += stride) {
    std::fill_n(rank, kRadius, rank[kRadius]);
    std::fill_n(rank + kRadius + width, kRadius, rank[kRadius + width - 1]);
  }
  for_each([&](int u) HWY_ATTR {
    V window[kSide * kSide];
    HWY_UNROLL(25)
    for (int i = 0; i < kSide * kSide; ++i) {
      window[i] = hn::LoadU(d, sorted + i / kSide * stride + u + i % kSide);
    }
    Compare<kSelect>(window, std::make_index_sequence<std::size(kSelect)>());
    hn::StoreU(window[kMedian], d, to + u);
  });
}

void FilterRowOnTarget(const std::array<const int16_t*, kSide>& rows, int width, int16_t* sorted,
                       int16_t* to) {
  const hn::CappedTag<int16_t, 32> d;
  if (width < static_cast<int>(hn::MaxLanes(d))) {
    return FilterRow(hn::CappedTag<int16_t, 1>(), rows, width, sorted, to);
  }
  FilterRow(d, rows, width, sorted, to);
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout {

HWY_EXPORT(FilterRowOnTarget);

void FilterByMedian(const cv::Mat1s& from, cv::Mat1s& to) {
  ForRangesParallel(from.rows, from.rows, [&](const cv::Range& range) {
    std::vector<int16_t> sorted(static_cast<size_t>(kSide * (from.cols + 2 * kRadius)));
    for (int v = range.start; v < range.end; ++v) {
      std::array<const int16_t*, kSide> rows;
      for (int y = 0; y < kSide; ++y) {
        rows[static_cast<size_t>(y)] = from[std::clamp(v + y - kRadius, 0, from.rows - 1)];
      }
      HWY_DYNAMIC_DISPATCH(FilterRowOnTarget)(rows, from.cols, sorted.data(), to[v]);
    }
  });
}

}  // namespace sprout
#endif  // HWY_ONCE
