#ifndef SPROUT_SERVICES_PRIOR_EDGE_HYPOTHESES_H_
#define SPROUT_SERVICES_PRIOR_EDGE_HYPOTHESES_H_

#include <opencv2/core.hpp>
#include <span>

#include "common/core/disparity_image.h"
#include "services/prior/edge_triangles.h"

namespace sprout {

/// The two surfaces that each pixel of a triangle across a depth edge may lie on. Where there is no
/// such triangle, or they are less than kSmallestGapPx apart, both maps are without a disparity.
struct EdgeHypotheses {
  DisparityImage near;
  DisparityImage far;
  cv::Mat1i edge;  ///< of a pixel with hypotheses: which of the triangles
};

/// Paints both surfaces of triangles across depth edges. A pixel on the border of two gets the
/// later one's, if it has any.
///
/// @param size        of the left image, px.
/// @param hypotheses  are overwritten; their memory is used again when the size is the same.
/// O(triangles + pixels); on OpenCV's threads, with the same result for any number.
void PaintEdgeHypotheses(std::span<const EdgeTriangle> edges, cv::Size size,
                         EdgeHypotheses& hypotheses);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_EDGE_HYPOTHESES_H_
