#ifndef SPROUT_COMMON_CORE_QUANTILE_H_
#define SPROUT_COMMON_CORE_QUANTILE_H_

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <iterator>
#include <ranges>

namespace sprout {

// Values that occur, never a mean of two. Values are reordered: give a copy to keep them. NaN has
// no place in an order: take it out before. O(values).

/// The value that stands at `rank` (from 0) when they are sorted. @pre rank < number of values.
template <std::ranges::random_access_range Values>
auto OrderStatistic(Values&& values, size_t rank) {
  assert(rank < std::ranges::size(values));
  const auto place = std::ranges::begin(values) + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(std::ranges::begin(values), place, std::ranges::end(values));
  return *place;
}

/// The value that a share of n values is not above: rank ⌊share · n⌋. @pre values; 0 ≤ share < 1.
template <std::ranges::random_access_range Values>
auto Quantile(Values&& values, double share) {
  return OrderStatistic(
      values, static_cast<size_t>(share * static_cast<double>(std::ranges::size(values))));
}

/// The value in the middle, of an even number the upper one of two: rank ⌊n / 2⌋. @pre values.
template <std::ranges::random_access_range Values>
auto Median(Values&& values) {
  return OrderStatistic(values, std::ranges::size(values) / 2);
}

}  // namespace sprout

#endif  // SPROUT_COMMON_CORE_QUANTILE_H_
