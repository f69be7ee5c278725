#ifndef SPROUT_SERVICES_PRIOR_INTERPOLATION_H_
#define SPROUT_SERVICES_PRIOR_INTERPOLATION_H_

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/core/disparity_image.h"
#include "common/core/result.h"
#include "common/core/seed.h"
#include "services/prior/delaunay.h"
#include "services/prior/hull.h"
#include "services/prior/triangle_raster.h"

namespace sprout {

/// The prior disparity map D_p (paper, Alg. 1 step 1): linear interpolation of the seeds'
/// disparities over their Delaunay triangulation in the left image.
///
/// @param seeds      at least three.
/// @param triangles  of TriangulateSeeds() of these seeds, or of others on the same positions.
/// @param size       of the left rectified image, px.
/// @param map        whose memory is used if it is of that size; its pixels are lost.
/// @returns a map of that size without gaps: outside the hull of the seeds a pixel takes the value
///          of the nearest pixel in the hull (to within a pixel). An error that says why when there
///          is no triangle, or none that covers a pixel.
/// O(n + pixels); no I/O; thread-safe.
Result<DisparityImage> InterpolateSeeds(std::span<const Seed> seeds,
                                        std::span<const SeedTriangle> triangles, cv::Size size,
                                        DisparityImage map = {});

/// InterpolateSeeds() for frame after frame: keeps its memory, and allocates nothing once it has
/// seen a frame, the map apart. One object serves one caller at a time.
class SeedInterpolator {
 public:
  Result<DisparityImage> Interpolate(std::span<const Seed> seeds,
                                     std::span<const SeedTriangle> triangles, cv::Size size,
                                     DisparityImage map = {});

 private:
  std::vector<RowReach> reach_;  // of the triangles
  Hull hull_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_INTERPOLATION_H_
