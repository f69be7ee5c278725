#ifndef SPROUT_SERVICES_PRIOR_EDGE_TRIANGLES_H_
#define SPROUT_SERVICES_PRIOR_EDGE_TRIANGLES_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/core/seed.h"
#include "services/prior/delaunay.h"
#include "services/prior/piecewise_surface.h"
#include "services/prior/seed_neighbours.h"
#include "services/prior/seed_surface.h"
#include "services/prior/triangle_raster.h"

namespace sprout {

/// Between disparities that are less apart neither images nor seeds can tell, and there
/// interpolation does no harm.
inline constexpr float kSmallestGapPx = 0.5;

/// A triangle that spans a depth edge: its seeds, and those around, lie on two surfaces.
struct EdgeTriangle {
  static constexpr size_t kMostSeeds = 32;  ///< two steps around a triangle are usually 27

  std::array<Seed, 3> corners;
  RowReach rows;          ///< of the image
  PiecewiseSurface near;  ///< with the first corner as origin
  PiecewiseSurface far;
  std::array<int, kMostSeeds> nearby_seeds;  ///< see nearby()
  size_t nearby_count = 0;

  /// The seeds at the corners, their neighbours and the neighbours of those, but for the ones that
  /// BorderExtender has added.
  std::span<const int> nearby() const { return std::span(nearby_seeds).first(nearby_count); }
};

/// Finds the triangles across depth edges. Keeps its memory from frame to frame, so one object
/// serves one caller at a time.
class EdgeTriangleFinder {
 public:
  /// Triangles whose seeds differ by at least `edge_px`, and whose planes by half a pixel: their
  /// seeds are parted where the disparities gape most, and those around by where their planes lead
  /// to.
  ///
  /// @param triangles   of the surface's seeds.
  /// @param neighbours  of the seeds; those that it does not know have none.
  /// @returns valid until the next call, in the order of the triangles.
  /// O(triangles); on OpenCV's threads, with the same result for any number.
  std::span<const EdgeTriangle> Find(const SeedSurface& surface,
                                     std::span<const SeedTriangle> triangles,
                                     const SeedNeighbours& neighbours, double edge_px);

 private:
  std::vector<uint8_t> spans_edge_;    // of each triangle
  std::vector<SeedTriangle> corners_;  // of those that do
  std::vector<EdgeTriangle> edges_;
  std::vector<Surroundings> surroundings_;  // one a part
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_EDGE_TRIANGLES_H_
