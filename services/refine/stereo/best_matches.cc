// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include <algorithm>
#include <climits>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "services/refine/stereo/stereo_search.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/refine/stereo/best_matches.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "services/refine/stereo/byte_lanes-inl.h"

#ifndef SPROUT_SERVICES_REFINE_BEST_MATCHES_SHARED_
#define SPROUT_SERVICES_REFINE_BEST_MATCHES_SHARED_
namespace sprout::refine {
namespace {

constexpr uint16_t kNoSum = UINT16_MAX;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

struct MatchRow {
  const int16_t* first;
  int labels;
  int unique_percent;
  cv::Range columns;
  const uint16_t* down;  // sums of the first of these columns
  const uint16_t* up;
  int16_t* best;
  float* confirmed_px;  // null: not wanted
  // The sums and best labels of the right pixels u − d, from right to left, so that a pixel's
  // matches follow one another.
  uint16_t* right_sums;
  uint16_t* right_best;

  // Index of a disparity's right pixel in right_sums and right_best.
  int RightIndex(int u, int disparity) const { return columns.end - 1 - u + disparity; }
};

}  // namespace
}  // namespace sprout::refine
#endif  // once

HWY_BEFORE_NAMESPACE();
namespace sprout::refine {
namespace HWY_NAMESPACE {

constexpr Words kWord = {0, 1, 2, 3, 4, 5, 6, 7};

HWY_INLINE Words SumOf(const uint16_t* down, const uint16_t* up) { return Load(down) + Load(up); }

// Enters the sums of the labels from d on for the right pixels.
HWY_INLINE void EnterRight(Words sums, int d, uint16_t* right_sums, uint16_t* right_best) {
  const Words before = Load(right_sums);
  const auto is_better = sums < before;
  Store(is_better ? sums : before, right_sums);
  Store(is_better ? kWord + static_cast<uint16_t>(d) : Load(right_best), right_best);
}

// Label of the least sum of a pixel.
HWY_INLINE int LeastLabel(const MatchRow& row, int u, const uint16_t* down, const uint16_t* up) {
  constexpr int kLaneBits = 4;  // a sum and its lane in one number
  static_assert(1 << kLaneBits == kLanes &&
                (StereoRules::kMaxPathSums + 1) << kLaneBits <= UINT16_MAX);
  int least = INT_MAX;
  int label = 0;
  for (int i = 0; i < row.labels; i += kLanes) {
    const Words low = SumOf(down + i, up + i);
    const Words high = SumOf(down + i + kWords, up + i + kWords);
    const int key =
        LeastLane(Least(low << kLaneBits | kWord, high << kLaneBits | (kWord + kWords)));
    if (key >> kLaneBits < least) {
      least = key >> kLaneBits;
      label = i + (key & (kLanes - 1));
    }
    if (row.confirmed_px == nullptr) continue;
    const int d = row.first[u] + i;
    uint16_t* right_sums = row.right_sums + row.RightIndex(u, d);
    uint16_t* right_best = row.right_best + row.RightIndex(u, d);
    EnterRight(low, d, right_sums, right_best);
    EnterRight(high, d + kWords, right_sums + kWords, right_best + kWords);
  }
  return label;
}

// Whether the best beats all that are not beside it.
HWY_INLINE bool IsUnique(const MatchRow& row, const uint16_t* down, const uint16_t* up, int label) {
  Words least = Words{} + kNoSum;
  for (int i = 0; i < row.labels; i += kWords) {
    // 0 to 2 for the best and those beside it.
    const Words from = kWord + static_cast<uint16_t>(i - label + 1);
    least = Least(least, from > uint16_t{2} ? SumOf(down + i, up + i) : Words{} + kNoSum);
  }
  return LeastLane(least) * (100 - row.unique_percent) > (down[label] + up[label]) * 100;
}

// From a label to the minimum of the parabola through its sum and those beside it.
HWY_INLINE double SubPixel(const uint16_t* down, const uint16_t* up) {
  const int before = down[-1] + up[-1];
  const int after = down[1] + up[1];
  const int curvature = before - 2 * (down[0] + up[0]) + after;
  return curvature > 0 ? (before - after) / (2.0 * curvature) : 0;
}

void MatchRowOnTarget(const MatchRow& row) {
  const uint16_t* down = row.down;
  const uint16_t* up = row.up;
  for (int u = row.columns.start; u < row.columns.end; ++u, down += row.labels, up += row.labels) {
    if (row.first[u] == StereoSearch::kNowhere) continue;
    const int label = LeastLabel(row, u, down, up);
    row.best[u] = static_cast<int16_t>(row.first[u] + label);
    if (row.confirmed_px == nullptr) continue;
    // At the end of the range the minimum may lie beyond it.
    const bool is_inside = label > 0 && label < row.labels - 1 && row.best[u] <= u;
    if (!is_inside || !IsUnique(row, down, up, label)) continue;
    row.confirmed_px[u] = static_cast<float>(row.best[u] + SubPixel(down + label, up + label));
  }
  if (row.confirmed_px == nullptr) return;
  for (int u = row.columns.start; u < row.columns.end; ++u) {
    if (std::isnan(row.confirmed_px[u])) continue;
    const int best_of_right = row.right_best[row.RightIndex(u, row.best[u])];
    if (std::abs(best_of_right - row.best[u]) > StereoRules::kConfirmedPx)
      row.confirmed_px[u] = kNone;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::refine
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::refine {

HWY_EXPORT(MatchRowOnTarget);

void BestMatches::Choose(const StereoSearch& search, int v, const cv::Range& columns,
                         const uint16_t* down, const uint16_t* up, int16_t* best,
                         float* confirmed_px) {
  if (columns.empty()) return;
  const int16_t* first = search.first[v];
  if (confirmed_px != nullptr) {
    const int most = *std::max_element(first + columns.start, first + columns.end) + search.labels;
    const auto right_pixels = static_cast<size_t>(columns.size() + most);
    right_sums_.assign(right_pixels, kNoSum);
    right_best_.resize(right_pixels);
  }
  HWY_DYNAMIC_DISPATCH(MatchRowOnTarget)
  ({.first = first,
    .labels = search.labels,
    .unique_percent = StereoRules::UniquePercent(search.diagonal),
    .columns = columns,
    .down = down,
    .up = up,
    .best = best,
    .confirmed_px = confirmed_px,
    .right_sums = right_sums_.data(),
    .right_best = right_best_.data()});
}

}  // namespace sprout::refine
#endif  // HWY_ONCE
