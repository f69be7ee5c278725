#include "services/refine/vertical_disparity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/core/parallel.h"

namespace sprout::refine {
namespace {

constexpr int kRadius = 4;             // of the windows, px
constexpr int kMostRows = 3;           // that the right image is off
constexpr double kLeastVariance = 40;  // of the grey values in a window, so that noise is little
constexpr double kLeastCorrelation = 0.8;
constexpr size_t kMostSeeds = 4000;
constexpr int kColumns = 4;
constexpr int kRows = 3;
constexpr size_t kFewestInCell = 10;

bool Fits(double u, double v, cv::Size size, int rows) {
  return u > kRadius + 1 && u < size.width - kRadius - 2 && v > kRadius + rows &&
         v < size.height - kRadius - rows - 1;
}

// Pearson's correlation of two windows; 0 without texture.
double Correlation(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point at_left,
                   cv::Point at_right) {
  constexpr int kSide = 2 * kRadius + 1;
  constexpr double kPixels = kSide * kSide;
  int32_t sum_left = 0, sum_right = 0, squares_left = 0, squares_right = 0, products = 0;
  for (int y = -kRadius; y <= kRadius; ++y) {
    const uint8_t* a = left.ptr(at_left.y + y) + at_left.x - kRadius;
    const uint8_t* b = right.ptr(at_right.y + y) + at_right.x - kRadius;
    for (int x = 0; x < kSide; ++x) {
      sum_left += a[x];
      sum_right += b[x];
      squares_left += a[x] * a[x];
      squares_right += b[x] * b[x];
      products += a[x] * b[x];
    }
  }
  const double variance_left = squares_left / kPixels - sum_left / kPixels * (sum_left / kPixels);
  const double variance_right =
      squares_right / kPixels - sum_right / kPixels * (sum_right / kPixels);
  if (variance_left < kLeastVariance || variance_right < kLeastVariance) return 0;
  const double covariance = products / kPixels - sum_left / kPixels * (sum_right / kPixels);
  return covariance / std::sqrt(variance_left * variance_right);
}

// Rows that the right window of a correspondence is off; NaN when none is clear.
float RowsOff(const cv::Mat1b& left, const cv::Mat1b& right, const Seed& seed) {
  if (!Fits(seed.u, seed.v, left.size(), kMostRows) ||
      !Fits(seed.u_right, seed.v, right.size(), kMostRows)) {
    return VerticalDisparity::kUnknown;
  }
  const cv::Point at_left(cvRound(seed.u), cvRound(seed.v));
  const cv::Point at_right(cvRound(seed.u_right), cvRound(seed.v));
  std::array<double, 2 * kMostRows + 1> correlations{};
  for (int rows = -kMostRows; rows <= kMostRows; ++rows) {
    double& best = correlations[static_cast<size_t>(rows + kMostRows)];
    // A seed is known to a pixel or so.
    for (const int columns : {-1, 0, 1}) {
      best = std::max(best, Correlation(left, right, at_left, at_right + cv::Point(columns, rows)));
    }
  }
  const auto best = std::ranges::max_element(correlations);
  if (*best < kLeastCorrelation || best == correlations.begin() || best == correlations.end() - 1) {
    return VerticalDisparity::kUnknown;
  }
  const double above = best[-1];
  const double below = best[1];
  const double curvature = 2 * *best - above - below;
  if (!(curvature > 0)) return VerticalDisparity::kUnknown;
  const auto rows = static_cast<double>(best - correlations.begin()) - kMostRows;
  return static_cast<float>(rows + (below - above) / (2 * curvature));
}

float Median(std::vector<float>& values) {
  if (values.empty()) return VerticalDisparity::kUnknown;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

VerticalDisparity MeasureVerticalDisparity(const cv::Mat1b& left, const cv::Mat1b& right,
                                           std::span<const Seed> seeds) {
  const size_t count = std::min(seeds.size(), kMostSeeds);
  std::vector<float> rows_off(count);
  const auto seed_of = [&](size_t i) -> const Seed& { return seeds[i * seeds.size() / count]; };
  ForEachParallel(count, [&](size_t i) { rows_off[i] = RowsOff(left, right, seed_of(i)); });

  std::vector<float> all;
  std::array<std::vector<float>, static_cast<size_t>(kColumns * kRows)> in_cells;
  for (size_t i = 0; i < count; ++i) {
    if (std::isnan(rows_off[i])) continue;
    all.push_back(rows_off[i]);
    const int column = static_cast<int>(seed_of(i).u) * kColumns / left.cols;
    const int row = static_cast<int>(seed_of(i).v) * kRows / left.rows;
    in_cells[static_cast<size_t>(row * kColumns + column)].push_back(rows_off[i]);
  }
  VerticalDisparity result;
  result.cells_px = cv::Mat1f(kRows, kColumns, VerticalDisparity::kUnknown);
  result.windows = static_cast<int>(all.size());
  result.median_px = Median(all);
  for (size_t i = 0; i < in_cells.size(); ++i) {
    if (in_cells[i].size() < kFewestInCell) continue;
    result.cells_px(static_cast<int>(i)) = Median(in_cells[i]);
  }
  return result;
}

}  // namespace sprout::refine
