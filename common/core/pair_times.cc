#include "common/core/pair_times.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "common/core/quantile.h"

namespace sprout {
namespace {

// Of sorted times, ns; 0 where there are fewer than three.
double MedianStep(std::span<const int64_t> times) {
  std::vector<int64_t> steps;
  for (size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  return steps.size() < 2 ? 0 : static_cast<double>(Median(steps));
}

}  // namespace

PairedNames PairTimes(std::span<const int64_t> first, std::span<const int64_t> second,
                      double max_spread_ms) {
  constexpr double kNsPerMs = 1e6;
  // Of fast cameras neighbours are near, too, where each list lacks the image that the other has.
  const auto [shorter, longer] = std::minmax({MedianStep(first), MedianStep(second)});
  if (shorter > 0) max_spread_ms = std::min(max_spread_ms, 0.75 * longer / kNsPerMs);
  PairedNames paired{.by = PairedBy::kTime};
  paired.least_spread_ms = std::numeric_limits<double>::infinity();
  // The nearest time; the earlier one of two that are equally near.
  const auto nearest = [](std::span<const int64_t> times, int64_t time) {
    const auto behind = std::ranges::lower_bound(times, time);
    if (behind == times.begin()) return behind;
    if (behind == times.end() || time - *(behind - 1) <= *behind - time) return behind - 1;
    return behind;
  };
  std::vector<bool> taken(second.size(), false);
  for (size_t i = 0; i < first.size() && !second.empty(); ++i) {
    const auto other = nearest(second, first[i]);
    const double spread_ms = static_cast<double>(std::abs(*other - first[i])) / kNsPerMs;
    paired.least_spread_ms = std::min(paired.least_spread_ms, spread_ms);
    const auto at = static_cast<size_t>(other - second.begin());
    if (spread_ms <= max_spread_ms && *nearest(first, *other) == first[i] && !taken[at]) {
      paired.pairs.push_back({i, at});
      taken[at] = true;
    } else {
      paired.alone_first.push_back(i);
    }
  }
  for (size_t i = 0; i < second.size(); ++i) {
    if (!taken[i]) paired.alone_second.push_back(i);
  }
  return paired;
}

}  // namespace sprout
