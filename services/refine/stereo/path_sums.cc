// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include "services/refine/stereo/path_sums.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "services/refine/stereo/path_sums.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "services/refine/stereo/byte_lanes-inl.h"

#ifndef SPROUT_SERVICES_REFINE_PATH_SUMS_SHARED_
#define SPROUT_SERVICES_REFINE_PATH_SUMS_SHARED_
namespace sprout::refine {
namespace {

constexpr int kMaxPath = StereoRules::kMaxPath;
constexpr size_t kDirections = 4;  // from the pixel before, and in the row before from the one
                                   // before, the same and the next

// Entries on either side of a pixel's path costs that stand for disparities it has not. Ranges that
// are farther apart have no disparity in common, either.
constexpr int kPadding = 24;
constexpr uint8_t kNever = 200;  // greater than any path cost, and + P1 still 8 bits
static_assert(kMaxPath < kNever && kNever + StereoRules::kSmallStep <= UINT8_MAX &&
              2 * kMaxPath <= UINT8_MAX);

// The penalty of a large change, by the difference of grey values that it goes with.
constexpr auto kLargeSteps = [] {
  using Rules = StereoRules;
  std::array<uint8_t, UINT8_MAX + 1> steps{};
  for (int difference = 0; difference <= UINT8_MAX; ++difference) {
    steps[static_cast<size_t>(difference)] =
        static_cast<uint8_t>(std::max(Rules::kMinLarge, Rules::kLargeStep * Rules::kHalfLargeAt /
                                                            (Rules::kHalfLargeAt + difference)));
  }
  return steps;
}();

// A row of the image, with a column more at either end that is not looked at.
struct Line {
  std::vector<int16_t> first;
  std::vector<uint8_t> grey;
  // For each pixel and direction the costs of the paths that end there, less their minimum; between
  // pixels kNever.
  std::vector<uint8_t> paths;

  Line(int width, int labels)
      : first(static_cast<size_t>(width + 2), StereoSearch::kNowhere),
        grey(first.size()),
        paths(first.size() * kDirections * SlotOf(labels) + kPadding, kNever) {}

  static size_t SlotOf(int labels) { return static_cast<size_t>(labels + kPadding); }
};

// A row of the image and the one that paths come from.
struct Row {
  const Line& above;  // or below, when the order is upwards
  Line& here;
  int labels;
  int step;              // from a pixel to the next
  cv::Range columns;     // of the line
  const uint8_t* costs;  // of the first of these columns
  uint16_t* sums;
};

}  // namespace
}  // namespace sprout::refine
#endif  // once

HWY_BEFORE_NAMESPACE();
namespace sprout::refine {
namespace HWY_NAMESPACE {

// Makes one vector of two: its lanes come in turns from the one and the other, each the lesser of
// two.
HWY_INLINE Bytes Folded(Bytes a, Bytes b) {
  return Least(Shuffled<0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23>(a, b),
               Shuffled<8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31>(a, b));
}

template <int kLane>
HWY_INLINE Bytes Everywhere(Bytes x) {
  return Shuffled<kLane, kLane, kLane, kLane, kLane, kLane, kLane, kLane, kLane, kLane, kLane,
                  kLane, kLane, kLane, kLane, kLane>(x);
}

// Path costs of a pixel's labels, or of some of them, for four directions.
struct Paths {
  Bytes before, above_before, above, above_next;
};

// The least lane of each direction, in all lanes.
HWY_INLINE Paths LeastLanes(const Paths& paths) {
  // The directions by turns, four times.
  Bytes x = Folded(Folded(paths.before, paths.above), Folded(paths.above_before, paths.above_next));
  x = Least(x, Shuffled<8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7>(x));
  x = Least(x, Shuffled<4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11>(x));
  return {Everywhere<0>(x), Everywhere<1>(x), Everywhere<2>(x), Everywhere<3>(x)};
}

HWY_INLINE void StoreSums(const Paths& paths, uint16_t* sums) {
  // Two path costs are still 8 bits.
  const Bytes one = paths.before + paths.above_before;
  const Bytes other = paths.above + paths.above_next;
  Store(Widened<0>(one) + Widened<0>(other), sums);
  Store(Widened<1>(one) + Widened<1>(other), sums + kWords);
}

// The pixel before on a path.
struct Before {
  const uint8_t* costs;  // from the disparity on that comes first in this pixel
  Bytes large_step;
  bool has_same_range;
};

HWY_INLINE Before Find(const Line& line, size_t u, size_t direction, size_t slot, int first,
                       int grey) {
  const int shift = std::clamp(first - line.first[u], -kPadding + 1, kPadding - 1);
  // A path starts where nothing is known.
  const bool starts = line.first[u] == StereoSearch::kNowhere;
  const uint8_t large_step =
      starts ? uint8_t{0} : kLargeSteps[static_cast<size_t>(std::abs(grey - line.grey[u]))];
  return {line.paths.data() + (u * kDirections + direction) * slot + kPadding + shift,
          Bytes{} + large_step, shift == 0};
}

// Eq. (R14), in which the least of the pixel before is 0.
HWY_INLINE Bytes Step(Bytes cost, Bytes same, Bytes less, Bytes more, Bytes large_step) {
  const Bytes beside = Least(less, more) + uint8_t{StereoRules::kSmallStep};
  return Least(Least(same, beside), large_step) + cost;
}

HWY_INLINE Bytes Step(Bytes cost, const Before& before, int label) {
  const uint8_t* from = before.costs + label;
  return Step(cost, Load(from), Load(from - 1), Load(from + 1), before.large_step);
}

// From the pixel before, whose costs are still in a register: from memory they would come late.
HWY_INLINE Bytes Step(Bytes cost, const Before& before, Bytes last) {
  if (!before.has_same_range) return Step(cost, before, 0);
  const Bytes never = Bytes{} + kNever;
  const Bytes less = Shuffled<16, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14>(last, never);
  const Bytes more = Shuffled<1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16>(last, never);
  return Step(cost, last, less, more, before.large_step);
}

// One step of the four paths to a pixel.
struct PixelStep {
  Before before, above_before, above, above_next;
  const uint8_t* costs;
  uint16_t* sums;
  uint8_t* to;  // slots of the directions, one behind the other
  size_t slot;

  HWY_INLINE void StorePaths(const Paths& paths, int label) const {
    Store(paths.before, to + label);
    Store(paths.above_before, to + slot + label);
    Store(paths.above, to + 2 * slot + label);
    Store(paths.above_next, to + 3 * slot + label);
  }
};

// Adds a pixel with 16 labels. @param last  path costs of the pixel before; becomes those of this
// one.
HWY_INLINE void TakeStep(const PixelStep& step, Bytes& last) {
  const Bytes cost = Load(step.costs);
  Paths paths = {Step(cost, step.before, last), Step(cost, step.above_before, 0),
                 Step(cost, step.above, 0), Step(cost, step.above_next, 0)};
  StoreSums(paths, step.sums);
  const Paths least = LeastLanes(paths);
  last = paths.before - least.before;
  step.StorePaths({last, paths.above_before - least.above_before, paths.above - least.above,
                   paths.above_next - least.above_next},
                  0);
}

// Adds a pixel with more than 16 labels.
HWY_INLINE void TakeLongStep(const PixelStep& step, int labels) {
  const Bytes most = Bytes{} + uint8_t{UINT8_MAX};
  Paths least = {most, most, most, most};
  for (int i = 0; i < labels; i += kLanes) {
    const Bytes cost = Load(step.costs + i);
    const Paths paths = {Step(cost, step.before, i), Step(cost, step.above_before, i),
                         Step(cost, step.above, i), Step(cost, step.above_next, i)};
    StoreSums(paths, step.sums + i);
    step.StorePaths(paths, i);
    least = {Least(least.before, paths.before), Least(least.above_before, paths.above_before),
             Least(least.above, paths.above), Least(least.above_next, paths.above_next)};
  }
  least = LeastLanes(least);
  for (int i = 0; i < labels; i += kLanes) {
    uint8_t* to = step.to + i;
    step.StorePaths(
        {Load(to) - least.before, Load(to + step.slot) - least.above_before,
         Load(to + 2 * step.slot) - least.above, Load(to + 3 * step.slot) - least.above_next},
        i);
  }
}

void RowOnTarget(const Row& row) {
  const size_t slot = Line::SlotOf(row.labels);
  const int count = row.columns.size();
  Bytes last{};
  for (int i = 0; i < count; ++i) {
    const int column = row.step > 0 ? row.columns.start + i : row.columns.end - 1 - i;
    const auto u = static_cast<size_t>(column);
    const int first = row.here.first[u];
    if (first == StereoSearch::kNowhere) continue;
    const int grey = row.here.grey[u];
    const auto before_u = static_cast<size_t>(column - row.step);
    const auto next_u = static_cast<size_t>(column + row.step);
    const auto offset =
        (u - static_cast<size_t>(row.columns.start)) * static_cast<size_t>(row.labels);
    const PixelStep step{.before = Find(row.here, before_u, 0, slot, first, grey),
                         .above_before = Find(row.above, before_u, 1, slot, first, grey),
                         .above = Find(row.above, u, 2, slot, first, grey),
                         .above_next = Find(row.above, next_u, 3, slot, first, grey),
                         .costs = row.costs + offset,
                         .sums = row.sums + offset,
                         .to = row.here.paths.data() + u * kDirections * slot + kPadding,
                         .slot = slot};
    if (row.labels == kLanes) {
      TakeStep(step, last);
    } else {
      TakeLongStep(step, row.labels);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace sprout::refine
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sprout::refine {

HWY_EXPORT(RowOnTarget);

void AddUpPaths(const cv::Mat1b& left, const StereoSearch& search, const SearchRows& rows,
                const std::vector<uint8_t>& costs, int step, std::vector<uint16_t>& sums) {
  if (sums.size() < costs.size()) sums.resize(costs.size());
  Line above(left.cols, search.labels);
  Line here(left.cols, search.labels);
  for (int i = 0; i < left.rows; ++i) {
    const int v = step > 0 ? i : left.rows - 1 - i;
    std::copy_n(search.first[v], left.cols, here.first.begin() + 1);
    const cv::Range& columns = rows.columns(v);
    if (!columns.empty()) {
      std::copy_n(left[v], left.cols, here.grey.begin() + 1);
      const size_t begin = rows.IndexOf(v, columns.start) * static_cast<size_t>(search.labels);
      HWY_DYNAMIC_DISPATCH(RowOnTarget)
      ({.above = above,
        .here = here,
        .labels = search.labels,
        .step = step,
        .columns = columns + 1,
        .costs = costs.data() + begin,
        .sums = sums.data() + begin});
    }
    std::swap(above, here);
  }
}

}  // namespace sprout::refine
#endif  // HWY_ONCE
