#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/result.h"

namespace sprout {

/// Images whose times are at most this far apart belong together, ms, where nothing else is asked.
inline constexpr double kMaxSpreadMs = 20;

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

/// Joins the files of two cameras, the same way wherever Sprout reads folders. By the times in
/// their names where all have one (see StampOf()), also behind or before other words: each with the
/// nearest of the other list, where this holds both ways; behind seconds up to nine digits of
/// nanoseconds need no leading zeros. Otherwise by equal names: without the
/// extension, or without what all names of a list begin and end with (left_7.png and right_007.png
/// belong together, and x/im0.png and x/im1.png). Otherwise by the nearest number (of any unit, or
/// dates), where that is for most less than a quarter of a step away. Otherwise by their order,
/// which needs lists of one length that make the same steps, as far as their names are numbers, and
/// no two files of a folder with one name or number (2.png and 02.png, or 2.jpg).
/// @param first, second   paths; each list without repetitions.
/// @param max_spread_ms   by time: largest difference.
/// @returns the pairs, or why there is none. O(n log n).
Result<PairedNames> PairNames(std::span<const std::string> first,
                              std::span<const std::string> second,
                              double max_spread_ms = kMaxSpreadMs);

/// Joins times, each with the nearest of the other list, where this holds both ways.
/// @param first, second  ns; ascending.
PairedNames PairTimes(std::span<const int64_t> first, std::span<const int64_t> second,
                      double max_spread_ms);

/// The time that a name stands for, ns since 1970: a number of seconds, milliseconds, microseconds
/// or nanoseconds (10, 13, 16 or 19 digits, 18 before 2001), or of seconds with a fraction behind
/// '.', '_' or '-'. Nothing for other names, also for numbers that begin with 0.
std::optional<int64_t> StampOf(std::string_view name);

/// Whether a name comes before another: numbers in them by their value (2 before 10).
bool ComesBefore(std::string_view a, std::string_view b);

}  // namespace sprout
