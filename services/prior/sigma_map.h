#ifndef SPROUT_SERVICES_PRIOR_SIGMA_MAP_H_
#define SPROUT_SERVICES_PRIOR_SIGMA_MAP_H_

#include <opencv2/core.hpp>
#include <span>

#include "services/prior/delaunay.h"
#include "services/prior/seed_surface.h"

namespace sprout {

/// How sure a prior is: the standard deviation of its disparity in every triangle of seeds,
///   σ² = mean σ_k² + mean (P_k(c) − D(c))²,      (P1)
/// over the corners k, with σ_k of the seed, P_k the plane at it, c the centroid and D the linear
/// interpolation of the corners. The second term is small where the planes lead into each other,
/// and larger on curved surfaces and between coarse seeds. It is left out where it exceeds 1 px²:
/// across a depth edge the disparity is that of one surface or the other.
///
/// @param planes     at the seeds.
/// @param triangles  of these; of those that overlap the last one counts.
/// @param size       of the map, px.
/// @param sigma      PriorMap::sigma, kMaxSigmaCounts outside the triangles; memory of that size is
///                   used again.
/// O(triangles + pixels); on OpenCV's threads, with the same result for any number.
void PaintSigma(std::span<const LocalPlane> planes, std::span<const SeedTriangle> triangles,
                cv::Size size, cv::Mat1b& sigma);

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_SIGMA_MAP_H_
