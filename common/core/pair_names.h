#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/core/pair_times.h"
#include "common/core/result.h"

namespace sprout {

/// Images whose times are at most this far apart belong together, ms, where nothing else is asked.
inline constexpr double kMaxSpreadMs = 20;

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

/// The time that a name stands for, ns since 1970: a number of seconds, milliseconds, microseconds
/// or nanoseconds (10, 13, 16 or 19 digits, 18 before 2001), or of seconds with a fraction behind
/// '.', '_' or '-'. Nothing for other names, also for numbers that begin with 0.
std::optional<int64_t> StampOf(std::string_view name);

/// Whether a name comes before another: numbers in them by their value (2 before 10).
bool ComesBefore(std::string_view a, std::string_view b);

}  // namespace sprout
