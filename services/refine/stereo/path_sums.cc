// Compiled by Highway once for each instruction set; one of them is picked when the program runs.
#include <algorithm>
#include <array>
#include <cstdlib>

#include "services/refine/stereo/stereo_search.h"

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
// From the pixel before and the one above, and diagonally from the one above that and the next.
constexpr size_t kDirections = 4;

// Entries on either side of a pixel's path costs that stand for disparities it has not. Ranges that
// are farther apart have no disparity in common, either.
constexpr int kPadding = 24;
constexpr uint8_t kNever = 200;  // greater than any path cost, and + P1 still 8 bits
static_assert(kMaxPath < kNever && kNever + StereoRules::SmallStep(false) <= UINT8_MAX &&
              2 * kMaxPath <= UINT8_MAX);

// The penalty of a large change, by the difference of grey values that it goes with. The quotient
// is never so near to a whole number that rounding could reach it.
inline uint8_t LargeStep(int difference) {
  using Rules = StereoRules;
  constexpr float kNumerator = Rules::kLargeStep * Rules::kHalfLargeAt;
  const float step = kNumerator / static_cast<float>(Rules::kHalfLargeAt + difference);
  return static_cast<uint8_t>(std::max(Rules::kMinLarge, static_cast<int>(step)));
}

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

  static constexpr size_t SlotOf(int labels) { return static_cast<size_t>(labels + kPadding); }
};

// How paths come to the pixels of a row from one direction.
struct Links {
  std::vector<int16_t> shifts;       // from the first disparity of the pixel before to the pixel's
  std::vector<uint8_t> large_steps;  // 0 where a path starts, since nothing is known before

  explicit Links(int width) : shifts(static_cast<size_t>(width + 2)), large_steps(shifts.size()) {}
};
using AllLinks = std::array<Links, kDirections>;

// A row of the image and the one that paths come from.
struct Row {
  const Line& above;  // or below, when the order is upwards
  Line& here;
  AllLinks& links;
  int labels;
  bool diagonal;         // whether paths run so, too
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

// Path costs of a pixel's labels, or of some of them, for each direction.
template <size_t kCount>
using Paths = std::array<Bytes, kCount>;

// The least lane of each direction, in all lanes.
HWY_INLINE Paths<4> LeastLanes(const Paths<4>& paths) {
  // The directions by turns, four times.
  Bytes x = Folded(Folded(paths[0], paths[2]), Folded(paths[1], paths[3]));
  x = Least(x, Shuffled<8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7>(x));
  x = Least(x, Shuffled<4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11>(x));
  return {Everywhere<0>(x), Everywhere<1>(x), Everywhere<2>(x), Everywhere<3>(x)};
}

HWY_INLINE Paths<2> LeastLanes(const Paths<2>& paths) {
  Bytes x = Folded(paths[0], paths[1]);
  x = Least(x, Shuffled<8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7>(x));
  x = Least(x, Shuffled<4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11>(x));
  x = Least(x, Shuffled<2, 3, 0, 1, 6, 7, 4, 5, 10, 11, 8, 9, 14, 15, 12, 13>(x));
  return {Everywhere<0>(x), Everywhere<1>(x)};
}

// Two path costs are still 8 bits.
HWY_INLINE void StoreSums(const Paths<4>& paths, uint16_t* sums) {
  const Bytes one = paths[0] + paths[1];
  const Bytes other = paths[2] + paths[3];
  Store(Widened<0>(one) + Widened<0>(other), sums);
  Store(Widened<1>(one) + Widened<1>(other), sums + kWords);
}

HWY_INLINE void StoreSums(const Paths<2>& paths, uint16_t* sums) {
  const Bytes sum = paths[0] + paths[1];
  Store(Widened<0>(sum), sums);
  Store(Widened<1>(sum), sums + kWords);
}

// The pixel before on a path.
struct Before {
  const uint8_t* costs;  // from the disparity on that comes first in this pixel
  Bytes large_step;
  bool has_same_range;
};

// Plain loops, which the compiler makes vectors of.
void LinkPixels(const Row& row, const Line& from, int beside, Links& links) {
  const auto begin = static_cast<size_t>(row.columns.start);
  const int count = row.columns.size();
  const int16_t* HWY_RESTRICT first = row.here.first.data() + begin;
  const uint8_t* HWY_RESTRICT grey = row.here.grey.data() + begin;
  const int16_t* HWY_RESTRICT first_before = from.first.data() + begin + beside;
  const uint8_t* HWY_RESTRICT grey_before = from.grey.data() + begin + beside;
  int16_t* HWY_RESTRICT shifts = links.shifts.data() + begin;
  uint8_t* HWY_RESTRICT large_steps = links.large_steps.data() + begin;
  for (int i = 0; i < count; ++i) {
    const auto shift = static_cast<int16_t>(first[i] - first_before[i]);
    shifts[i] = std::clamp<int16_t>(shift, -kPadding + 1, kPadding - 1);
  }
  for (int i = 0; i < count; ++i) {
    large_steps[i] = LargeStep(std::abs(grey[i] - grey_before[i]));
  }
  for (int i = 0; i < count; ++i) {
    large_steps[i] = first_before[i] == StereoSearch::kNowhere ? uint8_t{0} : large_steps[i];
  }
}

// Eq. (M4), in which the least of the pixel before is 0.
template <uint8_t kSmallStep>
HWY_INLINE Bytes Step(Bytes cost, Bytes same, Bytes less, Bytes more, Bytes large_step) {
  const Bytes beside = Least(less, more) + kSmallStep;
  return Least(Least(same, beside), large_step) + cost;
}

template <uint8_t kSmallStep>
HWY_INLINE Bytes Step(Bytes cost, const Before& before, int label) {
  const uint8_t* from = before.costs + label;
  return Step<kSmallStep>(cost, Load(from), Load(from - 1), Load(from + 1), before.large_step);
}

// From the pixel before, whose costs are still in a register: from memory they would come late.
template <uint8_t kSmallStep>
HWY_INLINE Bytes Step(Bytes cost, const Before& before, Bytes last) {
  if (!before.has_same_range) return Step<kSmallStep>(cost, before, 0);
  const Bytes never = Bytes{} + kNever;
  const Bytes less = Shuffled<16, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14>(last, never);
  const Bytes more = Shuffled<1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16>(last, never);
  return Step<kSmallStep>(cost, last, less, more, before.large_step);
}

// One step of the paths to a pixel.
template <size_t kCount>
struct PixelStep {
  static constexpr uint8_t kSmallStep = StereoRules::SmallStep(kCount > 2);

  std::array<Before, kCount> before;
  const uint8_t* costs;
  uint16_t* sums;
  uint8_t* to;  // slots of the directions, one behind the other
  size_t slot;

  HWY_INLINE void StorePaths(const Paths<kCount>& paths, int label) const {
    HWY_UNROLL(4)
    for (size_t k = 0; k < kCount; ++k) Store(paths[k], to + k * slot + label);
  }
};

// Adds a pixel with 16 labels. @param last  path costs of the pixel before; becomes those of this
// one.
template <size_t kCount>
HWY_INLINE void TakeStep(const PixelStep<kCount>& step, Bytes& last) {
  const Bytes cost = Load(step.costs);
  Paths<kCount> paths;
  paths[0] = Step<PixelStep<kCount>::kSmallStep>(cost, step.before[0], last);
  HWY_UNROLL(4)
  for (size_t k = 1; k < kCount; ++k)
    paths[k] = Step<PixelStep<kCount>::kSmallStep>(cost, step.before[k], 0);
  StoreSums(paths, step.sums);
  const Paths<kCount> least = LeastLanes(paths);
  HWY_UNROLL(4)
  for (size_t k = 0; k < kCount; ++k) paths[k] -= least[k];
  last = paths[0];
  step.StorePaths(paths, 0);
}

// Adds a pixel with more than 16 labels.
template <size_t kCount>
HWY_INLINE void TakeLongStep(const PixelStep<kCount>& step, int labels) {
  Paths<kCount> least;
  least.fill(Bytes{} + uint8_t{UINT8_MAX});
  for (int i = 0; i < labels; i += kLanes) {
    const Bytes cost = Load(step.costs + i);
    Paths<kCount> paths;
    for (size_t k = 0; k < kCount; ++k) {
      paths[k] = Step<PixelStep<kCount>::kSmallStep>(cost, step.before[k], i);
      least[k] = Least(least[k], paths[k]);
    }
    StoreSums(paths, step.sums + i);
    step.StorePaths(paths, i);
  }
  least = LeastLanes(least);
  for (int i = 0; i < labels; i += kLanes) {
    Paths<kCount> paths;
    for (size_t k = 0; k < kCount; ++k) paths[k] = Load(step.to + k * step.slot + i) - least[k];
    step.StorePaths(paths, i);
  }
}

// Calls take(step) for the pixels of a row that are searched, in the order of the paths.
template <size_t kCount, typename Take>
HWY_INLINE void ForEachPixel(const Row& row, size_t slot, const Take& take) {
  const size_t pixel = kDirections * slot;
  const std::ptrdiff_t to_next = static_cast<std::ptrdiff_t>(pixel) * row.step;
  const int count = row.columns.size();
  for (int i = 0; i < count; ++i) {
    const int column = row.step > 0 ? row.columns.start + i : row.columns.end - 1 - i;
    const auto u = static_cast<size_t>(column);
    if (row.here.first[u] == StereoSearch::kNowhere) continue;
    const auto before = [&](const uint8_t* paths, size_t direction) HWY_ATTR {
      const Links& links = row.links[direction];
      const int shift = links.shifts[u];
      return Before{paths + direction * slot + shift, Bytes{} + links.large_steps[u], shift == 0};
    };
    uint8_t* const here = row.here.paths.data() + u * pixel + kPadding;
    const uint8_t* const above = row.above.paths.data() + u * pixel + kPadding;
    const auto offset =
        (u - static_cast<size_t>(row.columns.start)) * static_cast<size_t>(row.labels);
    PixelStep<kCount> step{{}, row.costs + offset, row.sums + offset, here, slot};
    step.before[0] = before(here - to_next, 0);
    step.before[1] = before(above, 1);
    if constexpr (kCount > 2) {
      step.before[2] = before(above - to_next, 2);
      step.before[3] = before(above + to_next, 3);
    }
    take(step);
  }
}

template <size_t kCount>
void AddRow(const Row& row) {
  LinkPixels(row, row.here, -row.step, row.links[0]);
  LinkPixels(row, row.above, 0, row.links[1]);
  if (kCount > 2) {
    LinkPixels(row, row.above, -row.step, row.links[2]);
    LinkPixels(row, row.above, row.step, row.links[3]);
  }
  if (row.labels == kLanes) {
    Bytes last{};
    ForEachPixel<kCount>(row, Line::SlotOf(kLanes),
                         [&](const auto& step) HWY_ATTR { TakeStep(step, last); });
  } else {
    ForEachPixel<kCount>(row, Line::SlotOf(row.labels),
                         [&](const auto& step) HWY_ATTR { TakeLongStep(step, row.labels); });
  }
}

void RowOnTarget(const Row& row) { row.diagonal ? AddRow<4>(row) : AddRow<2>(row); }

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
  const Links links(left.cols);
  AllLinks all_links = {links, links, links, links};
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
        .links = all_links,
        .labels = search.labels,
        .diagonal = search.diagonal,
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
