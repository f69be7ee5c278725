#include "services/prior/interpolation.h"

#include <cstdint>
#include <vector>

#include "common/core/parallel.h"

namespace sprout::prior {
namespace {

// Twice the area of a triangle, px²; negative where it runs the other way round.
double TwiceArea(const Corners& corners) {
  const auto& [a, b, c] = corners;
  return (double{b.u} - a.u) * (double{c.v} - a.v) - (double{c.u} - a.u) * (double{b.v} - a.v);
}

// Eq. (P4): the plane through the disparities of the corners.
Plane PlaneThrough(const Corners& corners, double twice_area) {
  constexpr double kSteepest = 1e6;  // slivers; their pixels are held between the corners
  const auto& [a, b, c] = corners;
  const double bd = double{b.disparity} - a.disparity;
  const double cd = double{c.disparity} - a.disparity;
  const double per_column = (bd * (double{c.v} - a.v) - cd * (double{b.v} - a.v)) / twice_area;
  const double per_row = (cd * (double{b.u} - a.u) - bd * (double{c.u} - a.u)) / twice_area;
  Plane plane = a;
  plane.per_column = static_cast<float>(std::clamp(per_column, -kSteepest, kSteepest));
  plane.per_row = static_cast<float>(std::clamp(per_row, -kSteepest, kSteepest));
  return plane;
}

// Eq. (P8).
double SigmaPx(const Corners& corners, double edge_px) {
  const auto& [a, b, c] = corners;
  const float u = (a.u + b.u + c.u) / 3;
  const float v = (a.v + b.v + c.v) / 3;
  const float disparity = (a.disparity + b.disparity + c.disparity) / 3;
  double squares = 0;
  for (const Plane& corner : corners) {
    const double off = double{corner.At(u, v)} - disparity;
    squares += double{corner.sigma_px} * corner.sigma_px;
    if (std::abs(off) < edge_px) squares += off * off;
  }
  return std::sqrt(squares / 3);
}

void PaintTriangle(const Corners& corners, double edge_px, const cv::Range& rows, PriorMap& map) {
  constexpr double kLeastArea = 1e-3;  // px², twice; holds no pixel that others do not have
  const double twice_area = TwiceArea(corners);
  if (std::abs(twice_area) < kLeastArea) return;
  constexpr float kOne = DisparityImage::kCountsPerPixel;
  constexpr float kMost = DisparityImage::kMaxPx;
  const auto& [a, b, c] = corners;
  const auto [least, most] = std::minmax({a.disparity, b.disparity, c.disparity});
  const float low = kOne * std::clamp(least, 0.F, kMost);
  const float high = kOne * std::clamp(most, 0.F, kMost);
  const Plane plane = PlaneThrough(corners, twice_area);
  const float slope = kOne * plane.per_column;
  const uint8_t sigma = SigmaToCounts(SigmaPx(corners, edge_px));
  ForEachRun(corners, map.disparity.width(), rows, [&](int v, int begin, int end) {
    int16_t* const counts = map.disparity.counts()[v] + begin;
    const float first = kOne * plane.At(static_cast<float>(begin), static_cast<float>(v));
    for (int i = 0; i < end - begin; ++i) {
      const float value = first + slope * static_cast<float>(i);
      counts[i] = static_cast<int16_t>(std::min(std::max(value, low), high) + 0.5F);
    }
    std::fill(map.sigma[v] + begin, map.sigma[v] + end, sigma);
  });
}

// Gives the pixels of a row that have no disparity that of the nearest one that has.
// @returns false where there is none in the row.
bool FillRow(int16_t* row, int width) {
  const auto find = [&](int from, bool painted) {
    return static_cast<int>(std::find_if(row + from, row + width,
                                         [&](int16_t counts) {
                                           return (counts != DisparityImage::kInvalid) == painted;
                                         }) -
                            row);
  };
  int gap = find(0, false);
  if (gap == 0 && find(0, true) == width) return false;
  while (gap < width) {
    const int end = find(gap, true);
    const int middle = gap == 0 ? 0 : end == width ? width : (gap + end) / 2;
    if (middle > gap) std::fill(row + gap, row + middle, row[gap - 1]);
    if (end > middle) std::fill(row + middle, row + end, row[end]);
    gap = find(end, false);
  }
  return true;
}

// The same for all rows, and for rows without any from the nearest row that has some.
// @returns false where there is none at all.
bool FillGaps(cv::Mat1s& counts) {
  std::vector<int> filled;
  for (int v = 0; v < counts.rows; ++v) {
    if (FillRow(counts[v], counts.cols)) filled.push_back(v);
  }
  if (filled.empty()) return false;
  for (int v = 0; v < counts.rows; ++v) {
    const auto below = std::lower_bound(filled.begin(), filled.end(), v);
    if (below != filled.end() && *below == v) continue;
    const bool above_is_nearer =
        below == filled.end() || (below != filled.begin() && v - below[-1] <= *below - v);
    std::copy_n(counts[above_is_nearer ? below[-1] : *below], counts.cols, counts[v]);
  }
  return true;
}

}  // namespace

Result<void> Interpolate(std::span<const Plane> planes, std::span<const SeedTriangle> triangles,
                         double edge_px, PriorMap& map) {
  PaintInBands(map.size().height, [&](const cv::Range& rows) {
    map.disparity.counts().rowRange(rows) = DisparityImage::kInvalid;
    map.sigma.rowRange(rows) = kMaxSigmaCounts;
    for (const SeedTriangle& triangle : triangles) {
      if (Meets(planes, triangle, rows)) {
        PaintTriangle(CornersOf(planes, triangle), edge_px, rows, map);
      }
    }
  });
  if (!FillGaps(map.disparity.counts())) {
    return Fail("the seeds' triangles cover no pixel: no prior");
  }
  return {};
}

}  // namespace sprout::prior
