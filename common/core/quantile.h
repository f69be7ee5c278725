#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <iterator>
#include <ranges>

namespace sprout {

// Quantiles that are among the values, never a mean of two. The values are reordered: pass a copy
// to keep their order. They must not contain NaN. O(values).

/// The value at `rank` (from 0) in sorted order. @pre rank < number of values.
template <std::ranges::random_access_range Values>
auto OrderStatistic(Values&& values, size_t rank) {
  assert(rank < std::ranges::size(values));
  const auto place = std::ranges::begin(values) + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(std::ranges::begin(values), place, std::ranges::end(values));
  return *place;
}

/// The quantile `share` of n values: rank ⌊share · n⌋. @pre values; 0 ≤ share < 1.
template <std::ranges::random_access_range Values>
auto Quantile(Values&& values, double share) {
  return OrderStatistic(
      values, static_cast<size_t>(share * static_cast<double>(std::ranges::size(values))));
}

/// The median, of an even number of values the upper one: rank ⌊n / 2⌋. @pre values.
template <std::ranges::random_access_range Values>
auto Median(Values&& values) {
  return OrderStatistic(values, std::ranges::size(values) / 2);
}

}  // namespace sprout
