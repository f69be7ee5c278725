#include "services/prior/edge_hypotheses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <vector>

#include "common/core/parallel.h"
#include "services/prior/triangle_raster.h"

namespace sprout {
namespace {

// Between disparities that are less apart neither images nor seeds can tell, and there
// interpolation does no harm.
constexpr float kSmallestGapPx = 0.5;

// A number that changes linearly over the image.
struct Linear {
  float at_origin;
  float per_column;
  float per_row;

  float At(float u, float v) const { return at_origin + per_column * u + per_row * v; }
};

Linear ToLinear(const LocalPlane& plane) {
  return {plane.At(0, 0), plane.per_column, plane.per_row};
}

// Positive where b is closer than a, in squares of pixels.
Linear CloserTo(const LocalPlane& b, const LocalPlane& a) {
  const float across = b.u - a.u;
  const float down = b.v - a.v;
  return {-(across * (a.u + b.u) + down * (a.v + b.v)) / 2, across, down};
}

// As ToCounts(), but always with a disparity, never beyond infinity, and much faster.
int16_t NearestCounts(float disparity_px) {
  constexpr float kMost = DisparityImage::kMaxPx;
  constexpr float kOne = DisparityImage::kCountsPerPixel;
  return static_cast<int16_t>(std::clamp(disparity_px, 0.F, kMost) * kOne + 0.5F);
}

// The seeds of a triangle, parted where their disparities gape most.
class SplitTriangle {
 public:
  explicit SplitTriangle(const std::array<LocalPlane, 3>& planes) : planes_(planes) {
    std::sort(planes_.begin(), planes_.end(),
              [](const LocalPlane& a, const LocalPlane& b) { return a.disparity < b.disparity; });
    const bool two_far =
        planes_[1].disparity - planes_[0].disparity < planes_[2].disparity - planes_[1].disparity;
    const auto& [single, one, other] = two_far ? std::tie(planes_[2], planes_[0], planes_[1])
                                               : std::tie(planes_[0], planes_[1], planes_[2]);
    single_ = ToLinear(single);
    one_ = ToLinear(one);
    other_ = ToLinear(other);
    closer_to_other_ = CloserTo(other, one);
  }

  // Planes gape most at a corner.
  bool IsApartSomewhere() const {
    return std::any_of(planes_.begin(), planes_.end(), [&](const LocalPlane& corner) {
      const float single = single_.At(corner.u, corner.v);
      return std::abs(single - one_.At(corner.u, corner.v)) >= kSmallestGapPx ||
             std::abs(single - other_.At(corner.u, corner.v)) >= kSmallestGapPx;
    });
  }

  // @param edge  whose seeds these are.
  void Paint(const PixelRun& run, int edge, EdgeHypotheses& hypotheses) const {
    int16_t* const near = hypotheses.near.counts()[run.v];
    int16_t* const far = hypotheses.far.counts()[run.v];
    int* const edges = hypotheses.edge[run.v];
    const auto row = static_cast<float>(run.v);
    for (int u = run.begin; u < run.end; ++u) {
      const auto column = static_cast<float>(u);
      const Linear& closer = closer_to_other_.At(column, row) > 0 ? other_ : one_;
      const float pair = closer.At(column, row);
      const float single = single_.At(column, row);
      if (std::abs(single - pair) < kSmallestGapPx) continue;
      near[u] = NearestCounts(std::max(single, pair));
      far[u] = NearestCounts(std::min(single, pair));
      edges[u] = edge;
    }
  }

 private:
  std::array<LocalPlane, 3> planes_;  // far to near
  Linear single_;                     // surface of the seed that lies alone
  Linear one_;                        // and of the other two
  Linear other_;
  Linear closer_to_other_;
};

float SpreadPx(const SeedSurface& surface, const SeedTriangle& triangle) {
  const auto disparity = [&](size_t i) {
    return surface.planes[static_cast<size_t>(triangle[i])].disparity;
  };
  const auto [least, most] = std::minmax({disparity(0), disparity(1), disparity(2)});
  return most - least;
}

Seed Position(const LocalPlane& plane) { return {.u = plane.u, .v = plane.v, .u_right = 0}; }

void PaintTriangle(const std::array<LocalPlane, 3>& planes, int edge, const cv::Range& rows,
                   EdgeHypotheses& hypotheses) {
  const SplitTriangle split(planes);
  if (!split.IsApartSomewhere()) return;
  const TriangleRaster raster(Position(planes[0]), Position(planes[1]), Position(planes[2]),
                              hypotheses.near.width(), rows);
  for (int v = raster.first_row(); v < raster.end_row(); ++v) {
    split.Paint(raster.Run(v), edge, hypotheses);
  }
}

}  // namespace

void PaintEdgeHypotheses(const SeedSurface& surface, std::span<const SeedTriangle> triangles,
                         double edge_px, cv::Size size, EdgeHypotheses& hypotheses) {
  const auto planes_of = [&](const SeedTriangle& triangle) {
    const auto plane = [&](size_t i) { return surface.planes[static_cast<size_t>(triangle[i])]; };
    return std::array{plane(0), plane(1), plane(2)};
  };
  std::vector<EdgeTriangle>& edges = hypotheses.edges;
  edges.clear();
  for (const SeedTriangle& triangle : triangles) {
    if (SpreadPx(surface, triangle) < static_cast<float>(edge_px)) continue;
    const std::array<LocalPlane, 3> planes = planes_of(triangle);
    edges.push_back(
        {triangle, ReachOf(Position(planes[0]), Position(planes[1]), Position(planes[2]))});
  }
  hypotheses.near.counts().create(size);
  hypotheses.far.counts().create(size);
  hypotheses.edge.create(size);
  PaintInBands(size.height, [&](const cv::Range& rows) {
    Clear(hypotheses.near, rows);
    Clear(hypotheses.far, rows);
    for (size_t i = 0; i < edges.size(); ++i) {
      if (!edges[i].rows.Meets(rows)) continue;
      PaintTriangle(planes_of(edges[i].seeds), static_cast<int>(i), rows, hypotheses);
    }
  });
}

}  // namespace sprout
