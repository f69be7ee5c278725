#include "services/tools/calibrate/vertical_disparity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/core/parallel.h"
#include "common/core/quantile.h"
#include "common/core/window_sums.h"

namespace sprout::calibrate {
namespace {

struct VerticalRules {
  static constexpr int kRadius = 4;   ///< of the windows, px
  static constexpr int kMaxRows = 3;  ///< that the right image is off
  /// Least variance of the grey values in a window: a camera's noise (2 grey levels) is a tenth of
  /// it.
  static constexpr double kMinVariance = 40;
  /// Least correlation: with that noise in both windows 40 / (40 + 4) = 0.9 is left, and less half
  /// a pixel beside.
  static constexpr double kMinCorrelation = 0.8;
  static constexpr size_t kMaxSeeds = 4000;  ///< more cost time and do not help a median
  static constexpr int kColumns = 4;         ///< of cells
  static constexpr int kRows = 3;
  static constexpr size_t kFewestInCell = 10;  ///< windows, for a median that few cannot spoil
};

bool Fits(double u, double v, cv::Size size) {
  return IsInside(u, v, size, VerticalRules::kRadius + 1,
                  VerticalRules::kRadius + VerticalRules::kMaxRows);
}

// Pearson's correlation of two windows; 0 without texture.
double Correlation(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point at_left,
                   cv::Point at_right) {
  constexpr double kPixels = (2 * VerticalRules::kRadius + 1) * (2 * VerticalRules::kRadius + 1);
  const WindowSums sums = SumWindows<VerticalRules::kRadius>(left, right, at_left, at_right);
  const double mean_left = sums.left / kPixels;
  const double mean_right = sums.right / kPixels;
  const double variance_left = sums.left_squares / kPixels - mean_left * mean_left;
  const double variance_right = sums.right_squares / kPixels - mean_right * mean_right;
  if (variance_left < VerticalRules::kMinVariance || variance_right < VerticalRules::kMinVariance)
    return 0;
  const double covariance = sums.products / kPixels - mean_left * mean_right;
  return covariance / std::sqrt(variance_left * variance_right);
}

// Rows that the right window of a correspondence is off; NaN when none is clear.
float RowsOff(const cv::Mat1b& left, const cv::Mat1b& right, const Seed& seed) {
  if (!Fits(seed.u, seed.v, left.size()) || !Fits(seed.u_right, seed.v, right.size())) {
    return VerticalDisparity::kUnknown;
  }
  const cv::Point at_left(cvRound(seed.u), cvRound(seed.v));
  const cv::Point at_right(cvRound(seed.u_right), cvRound(seed.v));
  std::array<double, 2 * VerticalRules::kMaxRows + 1> correlations{};
  for (int rows = -VerticalRules::kMaxRows; rows <= VerticalRules::kMaxRows; ++rows) {
    double& best = correlations[static_cast<size_t>(rows + VerticalRules::kMaxRows)];
    // A seed is known to a pixel or so.
    for (const int columns : {-1, 0, 1}) {
      best = std::max(best, Correlation(left, right, at_left, at_right + cv::Point(columns, rows)));
    }
  }
  const auto best = std::ranges::max_element(correlations);
  if (*best < VerticalRules::kMinCorrelation || best == correlations.begin() ||
      best == correlations.end() - 1) {
    return VerticalDisparity::kUnknown;
  }
  const double above = best[-1];
  const double below = best[1];
  const double curvature = 2 * *best - above - below;
  if (!(curvature > 0)) return VerticalDisparity::kUnknown;
  const auto rows = static_cast<double>(best - correlations.begin()) - VerticalRules::kMaxRows;
  return static_cast<float>(rows + (below - above) / (2 * curvature));
}

}  // namespace

VerticalDisparity MeasureVerticalDisparity(const cv::Mat1b& left, const cv::Mat1b& right,
                                           std::span<const Seed> seeds) {
  const size_t count = std::min(seeds.size(), VerticalRules::kMaxSeeds);
  std::vector<float> rows_off(count);
  const auto seed_of = [&](size_t i) -> const Seed& { return seeds[i * seeds.size() / count]; };
  ForEachParallel(count, [&](size_t i) { rows_off[i] = RowsOff(left, right, seed_of(i)); });

  std::vector<float> all;
  std::array<std::vector<float>,
             static_cast<size_t>(VerticalRules::kColumns * VerticalRules::kRows)>
      in_cells;
  for (size_t i = 0; i < count; ++i) {
    if (std::isnan(rows_off[i])) continue;
    all.push_back(rows_off[i]);
    const int column = static_cast<int>(seed_of(i).u) * VerticalRules::kColumns / left.cols;
    const int row = static_cast<int>(seed_of(i).v) * VerticalRules::kRows / left.rows;
    in_cells[static_cast<size_t>(row * VerticalRules::kColumns + column)].push_back(rows_off[i]);
  }
  VerticalDisparity result;
  result.cells_px =
      cv::Mat1f(VerticalRules::kRows, VerticalRules::kColumns, VerticalDisparity::kUnknown);
  result.windows = static_cast<int>(all.size());
  if (!all.empty()) result.median_px = Median(all);
  for (size_t i = 0; i < in_cells.size(); ++i) {
    if (in_cells[i].size() < VerticalRules::kFewestInCell) continue;
    result.cells_px(static_cast<int>(i)) = Median(in_cells[i]);
  }
  return result;
}

}  // namespace sprout::calibrate
