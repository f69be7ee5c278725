#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sprout {

/// What says that two files belong together.
enum class PairedBy {
  kTime,   ///< the times in their names, or numbers that count alike
  kName,   ///< what differs within a list of names is equal in both
  kOrder,  ///< nothing: the lists are equally long, so the first belongs to the first, and so on
};

/// Files of two lists that belong together.
struct PairedNames {
  struct Pair {
    size_t first = 0;   ///< index in the first list
    size_t second = 0;  ///< index in the second list
  };
  PairedBy by = PairedBy::kName;
  std::vector<Pair> pairs = {};  ///< in the order of their times or numbers
  std::vector<size_t> alone_first = {};
  std::vector<size_t> alone_second = {};
  /// kTime: the smallest difference of times between the lists, ms, also where it is too large.
  double least_spread_ms = 0;
};

/// Joins times, each with the nearest of the other list, where this holds both ways.
/// @param first, second  ns; ascending.
PairedNames PairTimes(std::span<const int64_t> first, std::span<const int64_t> second,
                      double max_spread_ms);

}  // namespace sprout
