#ifndef SPROUT_SERVICES_PRIOR_EDGE_HYPOTHESES_H_
#define SPROUT_SERVICES_PRIOR_EDGE_HYPOTHESES_H_

#include <cstddef>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/disparity_image.h"
#include "services/prior/delaunay.h"
#include "services/prior/seed_surface.h"
#include "services/prior/triangle_raster.h"

namespace sprout {

/// A triangle that spans a depth edge.
struct EdgeTriangle {
  SeedTriangle seeds;
  RowReach rows;  ///< of the image
};

/// The two surfaces that each pixel of a triangle across a depth edge may lie on. Where there is no
/// such triangle, or they are less than half a pixel apart, both maps are without a disparity.
struct EdgeHypotheses {
  DisparityImage near;
  DisparityImage far;
  std::vector<EdgeTriangle> edges;  ///< those that they come from
  cv::Mat1i edge;                   ///< of a pixel with hypotheses: which of `edges`

  /// The seeds around a pixel that has hypotheses.
  const SeedTriangle& TriangleAt(int u, int v) const {
    return edges[static_cast<size_t>(edge(v, u))].seeds;
  }
};

/// Hypotheses for the pixels of triangles whose seeds differ by at least `edge_px`: such a triangle
/// spans a depth edge, and its seeds lie on two surfaces, parted where their disparities gape most.
/// The surface of one seed is its plane; that of two is the plane of the closer one.
///
/// @param surface      of the seeds.
/// @param triangles    of the seeds; a pixel on the border of two gets the later one's, if it has
/// any.
/// @param size         of the left image, px.
/// @param hypotheses   are overwritten; their memory is used again when the size is the same.
/// O(triangles + pixels); on OpenCV's threads, with the same result for any number.
void PaintEdgeHypotheses(const SeedSurface& surface, std::span<const SeedTriangle> triangles,
                         double edge_px, cv::Size size, EdgeHypotheses& hypotheses);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_EDGE_HYPOTHESES_H_
