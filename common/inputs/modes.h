#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "common/core/quantile.h"

namespace sprout::inputs {

/// The factor that most comparisons would agree with: the mode of their ratios.
inline double BestFactor(const std::vector<double>& logs) {
  constexpr double kBinsPerE = 40;  // of ln(factor): 2.5 % each
  constexpr double kMaxFactor = 1e5;
  const double most = std::log(kMaxFactor);
  std::vector<int> bins(static_cast<size_t>(2 * most * kBinsPerE) + 4, 0);
  for (const double value : logs) {
    if (std::abs(value) >= most) continue;
    ++bins[1 + static_cast<size_t>((value + most) * kBinsPerE)];
  }
  size_t best = 1;
  const auto around = [&](size_t i) { return bins[i - 1] + 2 * bins[i] + bins[i + 1]; };
  for (size_t i = 1; i + 1 < bins.size(); ++i) {
    if (around(i) > around(best)) best = i;
  }
  const double middle = (static_cast<double>(best) - 0.5) / kBinsPerE - most;
  std::vector<double> near;
  for (const double value : logs) {
    if (std::abs(value - middle) < 2 / kBinsPerE) near.push_back(value);
  }
  return near.empty() ? 1 : std::exp(Median(near));
}

/// The middle of where most of the numbers lie within 2 px.
inline double ModeOf(std::vector<double> offs_px) {
  constexpr double kWithinPx = 2;
  std::ranges::sort(offs_px);
  size_t begin = 0;
  size_t count = 0;
  for (size_t first = 0, end = 0; first < offs_px.size(); ++first) {
    while (end < offs_px.size() && offs_px[end] <= offs_px[first] + kWithinPx) ++end;
    if (end - first <= count) continue;
    begin = first;
    count = end - first;
  }
  return offs_px[begin + count / 2];
}

}  // namespace sprout::inputs
