#include "services/prior/interpolation.h"

#include <cstdint>
#include <vector>

#include "common/core/parallel.h"
#include "services/prior/paint_kernel.h"

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
    for (int v = rows.start; v < rows.end; ++v) {
      std::fill_n(map.disparity.counts()[v], map.size().width, DisparityImage::kInvalid);
      std::fill_n(map.sigma[v], map.size().width, kMaxSigmaCounts);
    }
    PaintTriangles(planes, triangles, edge_px, rows, map);
  });
  if (!FillGaps(map.disparity.counts())) {
    return Fail("the seeds' triangles cover no pixel: no prior");
  }
  return {};
}

}  // namespace sprout::prior
