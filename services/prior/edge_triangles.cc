#include "services/prior/edge_triangles.h"

#include <algorithm>
#include <cmath>

#include "common/core/parallel.h"

namespace sprout {
namespace {

// Fills in a triangle: parts its corners, then the seeds around.
class TriangleSplitter {
 public:
  TriangleSplitter(std::span<const LocalPlane> planes, const SeedTriangle& corners,
                   EdgeTriangle& edge)
      : planes_(planes), corners_(corners), edge_(edge), origin_(Position(corners[0])) {
    for (size_t i = 0; i < 3; ++i) {
      const LocalPlane& plane = Plane(corners[i]);
      edge.corners[i] = {plane.u, plane.v, plane.u - plane.disparity};
      places_[i] = Position(corners[i]) - origin_;
    }
    edge.rows = ReachOf(edge.corners[0], edge.corners[1], edge.corners[2]);
    edge.near.Clear();
    edge.far.Clear();
    const float middle = MiddleOfGap();
    for (int corner : corners) {
      AddTo(Plane(corner).disparity > middle ? edge.near : edge.far, corner);
    }
  }

  // Whether the planes of the corners differ anywhere.
  bool IsApart() const { return edge_.near.GapPx(edge_.far, places_) >= kSmallestGapPx; }

  // The other seeds around lie on the surface that their planes lead closer to. What leads far
  // beyond both is on a third one, and where the two have crossed nobody can tell.
  void SplitNearby(std::span<const int> seeds) {
    const cv::Point2f centre = (places_[0] + places_[1] + places_[2]) / 3;
    const float near = edge_.near.At(centre);
    const float far = edge_.far.At(centre);
    for (int seed : seeds) {
      if (std::find(corners_.begin(), corners_.end(), seed) != corners_.end()) continue;
      const float disparity = Plane(seed).At(origin_.x + centre.x, origin_.y + centre.y);
      const float from_middle = disparity - (near + far) / 2;
      if (std::abs(from_middle) > near - far) continue;
      AddTo(from_middle > 0 ? edge_.near : edge_.far, seed);
    }
  }

 private:
  const LocalPlane& Plane(int seed) const { return planes_[static_cast<size_t>(seed)]; }
  cv::Point2f Position(int seed) const { return {Plane(seed).u, Plane(seed).v}; }

  void AddTo(PiecewiseSurface& surface, int seed) const {
    surface.Add(Plane(seed), Position(seed) - origin_, places_);
  }

  // Where the disparities of the corners gape most.
  float MiddleOfGap() const {
    std::array<float, 3> disparities{Plane(corners_[0]).disparity, Plane(corners_[1]).disparity,
                                     Plane(corners_[2]).disparity};
    std::sort(disparities.begin(), disparities.end());
    const auto& [least, middle, most] = disparities;
    return (middle + (middle - least < most - middle ? most : least)) / 2;
  }

  std::span<const LocalPlane> planes_;
  const SeedTriangle& corners_;
  EdgeTriangle& edge_;
  cv::Point2f origin_;
  PiecewiseSurface::Corners places_;
};

bool SpansEdge(std::span<const LocalPlane> planes, const SeedTriangle& corners, double edge_px) {
  const auto disparity = [&](size_t i) {
    return planes[static_cast<size_t>(corners[i])].disparity;
  };
  const auto [least, most] = std::minmax({disparity(0), disparity(1), disparity(2)});
  if (most - least < static_cast<float>(edge_px)) return false;
  EdgeTriangle edge;
  return TriangleSplitter(planes, corners, edge).IsApart();
}

void LookAround(const SeedTriangle& corners, const SeedNeighbours& neighbours,
                Surroundings& surroundings, EdgeTriangle& edge) {
  SeedTriangle known = corners;
  const auto end = std::remove_if(known.begin(), known.end(), [&](int corner) {
    return static_cast<size_t>(corner) >= neighbours.size();
  });
  surroundings.Start({known.begin(), end});
  surroundings.Widen(EdgeTriangle::kMostSeeds);
  surroundings.Widen(EdgeTriangle::kMostSeeds);
  const std::span<const int> reached = surroundings.reached();
  std::copy(reached.begin(), reached.end(), edge.nearby_seeds.begin());
  edge.nearby_count = reached.size();
}

}  // namespace

std::span<const EdgeTriangle> EdgeTriangleFinder::Find(const SeedSurface& surface,
                                                       std::span<const SeedTriangle> triangles,
                                                       const SeedNeighbours& neighbours,
                                                       double edge_px) {
  spans_edge_.resize(triangles.size());
  ForEachParallel(triangles.size(), [&](size_t i) {
    spans_edge_[i] = SpansEdge(surface.planes, triangles[i], edge_px) ? 1 : 0;
  });
  corners_.clear();
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (spans_edge_[i] != 0) corners_.push_back(triangles[i]);
  }
  edges_.resize(corners_.size());
  constexpr size_t kParts = 8;
  surroundings_.resize(kParts);
  ForEachParallel(kParts, [&](size_t part) {
    surroundings_[part].Set(neighbours);
    const size_t end = edges_.size() * (part + 1) / kParts;
    for (size_t i = edges_.size() * part / kParts; i < end; ++i) {
      TriangleSplitter splitter(surface.planes, corners_[i], edges_[i]);
      LookAround(corners_[i], neighbours, surroundings_[part], edges_[i]);
      splitter.SplitNearby(edges_[i].nearby());
    }
  });
  return edges_;
}

}  // namespace sprout
