// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include <algorithm>
#include <utility>

#include "services/grow/fill/gap_filler.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/grow/fill/gap_medians.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef SPROUT_SERVICES_GROW_GAP_MEDIANS_SHARED_
#define SPROUT_SERVICES_GROW_GAP_MEDIANS_SHARED_
namespace sprout::grow {
namespace {

constexpr int kRadius = 2;
constexpr int kWindow = 2 * kRadius + 1;
constexpr size_t kPixels = kWindow * kWindow;
constexpr int16_t kGap = DisparityImage::kInvalid;

struct Comparator {
  uint8_t i, j;
};

// Batcher's odd-even merge sort of a window: calls compare(i, j), i < j, in order.
template <typename Compare>
constexpr void ForEachComparator(const Compare& compare) {
  for (size_t p = 1; p < kPixels; p *= 2) {
    for (size_t k = p; k >= 1; k /= 2) {
      for (size_t j = k % p; j + k < kPixels; j += 2 * k) {
        for (size_t i = j; i < std::min(j + k, kPixels - k); ++i) {
          if (i / (2 * p) == (i + k) / (2 * p)) compare(i, i + k);
        }
      }
    }
  }
}

constexpr size_t CountComparators() {
  size_t count = 0;
  ForEachComparator([&](size_t, size_t) { ++count; });
  return count;
}

constexpr auto kComparators = [] {
  std::array<Comparator, CountComparators()> comparators{};
  size_t count = 0;
  ForEachComparator([&](size_t i, size_t j) {
    comparators[count++] = {static_cast<uint8_t>(i), static_cast<uint8_t>(j)};
  });
  return comparators;
}();

// The five rows around a pixel, from two columns before it on, as far as kFillColumns windows
// reach. Beyond the map all are gaps.
class Surroundings {
 public:
  Surroundings(const DisparityImage& map, int v, int u) {
    const cv::Rect wanted(u - kRadius, v - kRadius, kColumns, kWindow);
    const cv::Rect inside = wanted & cv::Rect({}, map.size());
    if (inside != wanted) padded_.fill(kGap);
    for (int y = 0; y < kWindow; ++y) {
      const auto row = static_cast<size_t>(y);
      if (inside == wanted) {
        rows_[row] = map.counts()[wanted.y + y] + wanted.x;
        continue;
      }
      int16_t* padded = padded_.data() + y * kColumns;
      rows_[row] = padded;
      if (wanted.y + y < 0 || wanted.y + y >= map.height()) continue;
      std::copy_n(map.counts()[wanted.y + y] + inside.x, inside.width,
                  padded + (inside.x - wanted.x));
    }
  }

  const int16_t* row(size_t y) const { return rows_[y]; }

 private:
  static constexpr int kColumns = kFillColumns + 2 * kRadius;

  std::array<const int16_t*, kWindow> rows_;
  std::array<int16_t, kColumns * kWindow> padded_;
};

}  // namespace
}  // namespace sprout::grow
#endif  // once

HWY_BEFORE_NAMESPACE();
namespace sprout::grow {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<int16_t, kFillColumns>;
using V = hn::Vec<D>;

// Smaller ones to a, larger ones to b.
HWY_INLINE void Compare(V& a, V& b) {
  const V smaller = hn::Min(a, b);
  b = hn::Max(a, b);
  a = smaller;
}

// Sorts each lane. Written out by the compiler, so that values stay in registers.
template <size_t... kIndex>
HWY_INLINE void SortLanes(V (&values)[kPixels], std::index_sequence<kIndex...>) {
  (Compare(values[kComparators[kIndex].i], values[kComparators[kIndex].j]), ...);
}

// The sorted value of the given rank, for each lane.
template <size_t... kRank>
HWY_INLINE V Ranked(const V (&sorted)[kPixels], V rank, std::index_sequence<kRank...>) {
  const D d;
  V value = sorted[0];
  ((value = hn::IfThenElse(hn::Eq(rank, hn::Set(d, static_cast<int16_t>(kRank))), sorted[kRank],
                           value)),
   ...);
  return value;
}

// The median of the valid values of a window, for each lane; kGap when there are none.
HWY_INLINE V Medians(const Surroundings& around, int column) {
  const D d;
  V values[kPixels];
  V valid = hn::Zero(d);
  HWY_UNROLL(25)
  for (size_t i = 0; i < kPixels; ++i) {
    const V value = hn::LoadU(d, around.row(i / kWindow) + column + i % kWindow);
    const auto is_gap = hn::Eq(value, hn::Set(d, kGap));
    valid = hn::Add(valid, hn::IfThenZeroElse(is_gap, hn::Set(d, 1)));
    values[i] = hn::IfThenElse(is_gap, hn::Set(d, INT16_MAX), value);  // behind all disparities
  }
  SortLanes(values, std::make_index_sequence<kComparators.size()>());
  const V one = hn::Set(d, 1);
  const V rank = hn::ShiftRight<1>(hn::Sub(hn::Max(valid, one), one));
  const V median = Ranked(values, rank, std::make_index_sequence<kPixels / 2 + 1>());
  return hn::IfThenElse(hn::Eq(valid, hn::Zero(d)), hn::Set(d, kGap), median);
}

void FillPixelsOnTarget(const DisparityImage& map, int v, int u, FilledPixels& filled) {
  const D d;
  const Surroundings around(map, v, u);
  for (int column = 0; column < kFillColumns; column += static_cast<int>(hn::MaxLanes(d))) {
    V values = hn::LoadU(d, around.row(kRadius) + kRadius + column);
    const auto in_map = hn::FirstN(d, static_cast<size_t>(std::max(map.width() - u - column, 0)));
    const auto gaps = hn::And(hn::Eq(values, hn::Set(d, kGap)), in_map);
    if (!hn::AllFalse(d, gaps)) {
      values = hn::IfThenElse(gaps, Medians(around, column), values);
    }
    hn::StoreU(values, d, filled.data() + column);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::grow
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::grow {

HWY_EXPORT(FillPixelsOnTarget);

void FillPixels(const DisparityImage& map, int v, int u, FilledPixels& filled) {
  HWY_DYNAMIC_DISPATCH(FillPixelsOnTarget)(map, v, u, filled);
}

}  // namespace sprout::grow
#endif  // HWY_ONCE
