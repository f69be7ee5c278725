#include "services/prior/triangulation/interpolation.h"

#include <cstdint>

#include "common/core/parallel.h"

namespace sprout::prior {
namespace {

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
  // This loop becomes vector code. Most rows have no gap.
  int16_t least = INT16_MAX;
  for (int u = 0; u < width; ++u) least = std::min(least, row[u]);
  if (least != DisparityImage::kInvalid) return true;
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

// Gives rows without any disparity the nearest one that has some.
// @param is_filled  by row. @returns false where there is none.
bool FillRows(std::span<const uint8_t> is_filled, cv::Mat1s& counts) {
  std::vector<int> filled;
  for (int v = 0; v < counts.rows; ++v) {
    if (is_filled[static_cast<size_t>(v)] != 0) filled.push_back(v);
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
  const cv::Size size = map.size();
  const TrianglesByBand bands(
      planes, triangles.size(), [&](size_t i) { return triangles[i]; }, size.height);
  std::vector<uint8_t> is_filled(static_cast<size_t>(size.height));
  ForEachParallel(static_cast<size_t>(bands.size()), [&](size_t i) {
    const int band = static_cast<int>(i);
    const cv::Range rows = bands.RowsOf(band);
    for (int v = rows.start; v < rows.end; ++v) {
      std::fill_n(map.disparity.counts()[v], size.width, DisparityImage::kInvalid);
      std::fill_n(map.sigma[v], size.width, kMaxSigmaCounts);
    }
    PaintTriangles(planes, triangles, bands.TrianglesOf(band), edge_px, rows, map);
    for (int v = rows.start; v < rows.end; ++v) {
      is_filled[static_cast<size_t>(v)] = FillRow(map.disparity.counts()[v], size.width) ? 1 : 0;
    }
  });
  if (!FillRows(is_filled, map.disparity.counts())) {
    return Fail("the seeds' triangles cover no pixel: no prior");
  }
  return {};
}

}  // namespace sprout::prior
