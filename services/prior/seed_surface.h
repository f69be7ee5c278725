#ifndef SPROUT_SERVICES_PRIOR_SEED_SURFACE_H_
#define SPROUT_SERVICES_PRIOR_SEED_SURFACE_H_

#include <memory>
#include <span>
#include <vector>

#include "common/core/seed.h"
#include "services/prior/delaunay.h"
#include "services/prior/seed_neighbours.h"

namespace sprout {

/// The surface at a seed: its position in the left image, px, disparity as a plane there, px and px
/// of disparity a pixel, and the standard deviation of the disparity, px.
struct LocalPlane {
  float u = 0;
  float v = 0;
  float disparity = 0;
  float per_column = 0;
  float per_row = 0;
  float sigma_px = 0;

  /// Disparity of the plane at a pixel, px.
  float At(float at_u, float at_v) const {
    return disparity + per_column * (at_u - u) + per_row * (at_v - v);
  }
};

/// What the seeds say about the surfaces that they lie on.
struct SeedSurface {
  std::vector<LocalPlane> planes;  ///< one a seed, in their order
  double noise_px = 0;             ///< standard deviation of the ToF seeds' disparities: median, px
  double step_px = 0;              ///< in which they are counted; small where they are not
};

/// Fits a plane to each seed and its neighbours in the triangulation. Neighbours that lie on
/// another surface are left out softly (Geman-McClure weights, iteratively reweighted least
/// squares), and slopes are held back a little, since beside an edge they rest on few seeds.
///
/// The seeds say how noisy they are. Where ToF seeds are by more than `noisy_px` (their median),
/// and for every seed of stereo, the fit reaches the neighbours' neighbours too, and its disparity
/// stands for the seed's own. Elsewhere a seed's disparity gives way only a little, to the plane of
/// itself and those around it that differ by about a step or less: disparities come in steps, whose
/// width is estimated, too, by a low quantile of the differences of neighbours. On a wide step,
/// where the neighbours do not show which way the surface goes, theirs are asked as well.
///
/// Keeps its memory from frame to frame, so one object serves one caller at a time; in steady state
/// it allocates nothing.
class SeedSurfaceFitter {
 public:
  SeedSurfaceFitter();
  ~SeedSurfaceFitter();

  /// @param triangles  of TriangulateSeeds() of these seeds. A seed in none of them keeps its
  ///                   disparity, with a level plane.
  /// @param noisy_px   > 0.
  /// @param edge_px    without noise only the neighbours of seeds of triangles whose disparities
  ///                   differ by at least this get the slant of the robust fit; the others that of
  ///                   the plane that takes their steps off.
  /// @returns the surface; valid until the next call.
  /// O(seeds), but O(n²) for the neighbours of one seed; no I/O; on OpenCV's threads, with the same
  /// result for any number.
  const SeedSurface& Fit(std::span<const Seed> seeds, std::span<const SeedTriangle> triangles,
                         double noisy_px, double edge_px);

  /// Of the seeds of the last call.
  const SeedNeighbours& neighbours() const;

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_SEED_SURFACE_H_
