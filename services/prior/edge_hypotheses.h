#ifndef SPROUT_SERVICES_PRIOR_EDGE_HYPOTHESES_H_
#define SPROUT_SERVICES_PRIOR_EDGE_HYPOTHESES_H_

#include <opencv2/core.hpp>
#include <span>

#include "common/core/disparity_image.h"
#include "services/prior/delaunay.h"
#include "services/prior/seed_surface.h"

namespace sprout {

/// What ResolveEdges() looks at.
struct EdgeEvidence {
  cv::Mat3b left_bgr;   ///< colours of the left image, which say what belongs together
  cv::Mat1b left_grey;  ///< the pair that is matched
  cv::Mat1b right_grey;
  cv::Mat1f spread_px;       ///< SpreadSeeds() over the left image
  double edge_px = 0;        ///< seeds of a triangle that differ by more lie on two surfaces, px
  double spread_weight = 0;  ///< weight of spread_px against that of the images
};

/// Mends the prior where interpolation errs most. A triangle whose seeds lie on two surfaces spans
/// a depth edge, and interpolation paints a ramp there that does not exist: the pixel lies on the
/// near surface or on the far one. Both hypotheses, extrapolated from the planes of their seeds,
/// are scored for each pixel, and the better one stands:
///   the images: truncated absolute differences in a 9×9 window (13 pixels of it), weighted by
///     likeness of colour and by distance to the pixel (adaptive support weights: Yoon and Kweon,
///     PAMI 2006), so that the window does not reach over the edge;
///   the ToF camera: how far the hypothesis is from the disparity that the seeds spread there
///     along the image's edges.
///
/// @param surface    of the seeds.
/// @param triangles  of the seeds.
/// @param prior      their interpolation; changed in place in the triangles that span an edge.
/// Whole-number weights and differences: the same result on every machine.
/// O(pixels of these triangles · 13).
void ResolveEdges(const SeedSurface& surface, std::span<const SeedTriangle> triangles,
                  const EdgeEvidence& evidence, DisparityImage& prior);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_EDGE_HYPOTHESES_H_
