#include "services/prior/edge_hypotheses.h"

#include <algorithm>

#include "common/core/parallel.h"
#include "services/prior/triangle_raster.h"

namespace sprout {
namespace {

// As ToCounts(), but always with a disparity, never beyond infinity, and much faster.
int16_t NearestCounts(float disparity_px) {
  constexpr float kMost = DisparityImage::kMaxPx;
  constexpr float kOne = DisparityImage::kCountsPerPixel;
  return static_cast<int16_t>(std::min(std::max(0.F, disparity_px), kMost) * kOne + 0.5F);
}

// @param index  of the triangle.
void PaintRun(const EdgeTriangle& edge, int index, const PixelRun& run,
              EdgeHypotheses& hypotheses) {
  int16_t* const near = hypotheses.near.counts()[run.v];
  int16_t* const far = hypotheses.far.counts()[run.v];
  int* const edges = hypotheses.edge[run.v];
  const Seed& origin = edge.corners[0];
  const float down = static_cast<float>(run.v) - origin.v;
  for (int u = run.begin; u < run.end; ++u) {
    const cv::Point2f place(static_cast<float>(u) - origin.u, down);
    const auto [less, more] = std::minmax({edge.near.At(place), edge.far.At(place)});
    if (more - less < kSmallestGapPx) continue;
    near[u] = NearestCounts(more);
    far[u] = NearestCounts(less);
    edges[u] = index;
  }
}

}  // namespace

void PaintEdgeHypotheses(std::span<const EdgeTriangle> edges, cv::Size size,
                         EdgeHypotheses& hypotheses) {
  hypotheses.near.counts().create(size);
  hypotheses.far.counts().create(size);
  hypotheses.edge.create(size);
  PaintInBands(size.height, [&](const cv::Range& rows) {
    Clear(hypotheses.near, rows);
    Clear(hypotheses.far, rows);
    for (size_t i = 0; i < edges.size(); ++i) {
      if (!edges[i].rows.Meets(rows)) continue;
      const auto& [a, b, c] = edges[i].corners;
      const TriangleRaster raster(a, b, c, size.width, rows);
      for (int v = raster.first_row(); v < raster.end_row(); ++v) {
        PaintRun(edges[i], static_cast<int>(i), raster.Run(v), hypotheses);
      }
    }
  });
}

}  // namespace sprout
