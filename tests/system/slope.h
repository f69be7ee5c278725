#pragma once

#include <numeric>
#include <span>

namespace sprout {

/// Slope of the straight line that fits the points best (least squares); 0 for fewer than two.
inline double SlopeOf(std::span<const double> x, std::span<const double> y) {
  const auto count = static_cast<double>(x.size());
  if (x.size() < 2) return 0;
  const double mean_x = std::accumulate(x.begin(), x.end(), 0.0) / count;
  const double mean_y = std::accumulate(y.begin(), y.end(), 0.0) / count;
  double covariance = 0;
  double variance = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    covariance += (x[i] - mean_x) * (y[i] - mean_y);
    variance += (x[i] - mean_x) * (x[i] - mean_x);
  }
  return variance > 0 ? covariance / variance : 0;
}

}  // namespace sprout
