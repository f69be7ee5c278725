#include "services/prior/edges/edge_surfaces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/core/parallel.h"

namespace sprout::prior {
namespace {

// The disparity in the middle of the widest gap between the corners' disparities.
float MiddleOfGap(const Corners& corners) {
  std::array<float, 3> disparities{corners[0].disparity, corners[1].disparity,
                                   corners[2].disparity};
  std::sort(disparities.begin(), disparities.end());
  const auto& [least, middle, most] = disparities;
  return (middle + (middle - least < most - middle ? most : least)) / 2;
}

void SplitCorners(const Corners& corners, EdgeTriangle& edge) {
  const float middle = MiddleOfGap(corners);
  for (const Plane& corner : corners) {
    (corner.disparity > middle ? edge.near : edge.far).Add(corner);
  }
}

// Whether any planes of the two surfaces differ so much at a corner: otherwise nowhere in it.
bool AreApart(const EdgeTriangle& edge, const Corners& corners, double edge_px) {
  for (const Plane& near : edge.near.planes()) {
    for (const Plane& far : edge.far.planes()) {
      for (const Plane& at : corners) {
        if (std::abs(near.At(at.u, at.v) - far.At(at.u, at.v)) >= edge_px) return true;
      }
    }
  }
  return false;
}

bool SpansEdge(const Corners& corners, double edge_px) {
  const auto& [a, b, c] = corners;
  const auto [least, most] = std::minmax({a.disparity, b.disparity, c.disparity});
  if (most - least < static_cast<float>(edge_px)) return false;
  EdgeTriangle edge;
  SplitCorners(corners, edge);
  return AreApart(edge, corners, edge_px);
}

EdgeTriangle MakeEdge(std::span<const Plane> planes, const SeedTriangle& triangle, Rings& rings) {
  EdgeTriangle edge;
  edge.seeds = triangle;
  const std::span<const int> nearby = rings.Around(triangle, 2, EdgeTriangle::kMaxSeeds);
  std::copy(nearby.begin(), nearby.end(), edge.nearby_seeds.begin());
  edge.nearby_count = nearby.size();
  SplitCorners(CornersOf(planes, triangle), edge);
  return edge;
}

}  // namespace

std::vector<EdgeTriangle> FindEdgeTriangles(std::span<const Plane> planes,
                                            std::span<const SeedTriangle> triangles,
                                            const Triangulation& triangulation, double edge_px) {
  std::vector<uint8_t> spans_edge(triangles.size());
  ForEachParallel(triangles.size(), [&](size_t i) {
    spans_edge[i] = SpansEdge(CornersOf(planes, triangles[i]), edge_px) ? 1 : 0;
  });
  std::vector<SeedTriangle> across;
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (spans_edge[i] != 0) across.push_back(triangles[i]);
  }
  std::vector<EdgeTriangle> edges(across.size());
  const auto count = static_cast<int>(across.size());
  ForRangesParallel(count, 4 * cv::getNumThreads(), [&](const cv::Range& part) {
    Rings rings(triangulation);
    for (auto i = static_cast<size_t>(part.start); i < static_cast<size_t>(part.end); ++i) {
      edges[i] = MakeEdge(planes, across[i], rings);
    }
  });
  return edges;
}

void PaintLabels(std::span<const EdgeTriangle> edges, std::span<const Plane> planes, double edge_px,
                 cv::Size size, EdgeLabels& labels) {
  labels.near.create(size);
  labels.far.create(size);
  labels.triangle.create(size);
  const TrianglesByBand bands(
      planes, edges.size(), [&](size_t i) { return edges[i].seeds; }, size.height);
  ForEachParallel(static_cast<size_t>(bands.size()), [&](size_t band) {
    const cv::Range rows = bands.RowsOf(static_cast<int>(band));
    for (int v = rows.start; v < rows.end; ++v) {
      std::fill_n(labels.near[v], size.width, DisparityImage::kInvalid);
    }
    PaintEdgeLabels(edges, bands.TrianglesOf(static_cast<int>(band)), planes,
                    static_cast<float>(edge_px), rows, labels);
  });
}

}  // namespace sprout::prior
