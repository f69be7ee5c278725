#ifndef SPROUT_SERVICES_PRIOR_DELAUNAY_H_
#define SPROUT_SERVICES_PRIOR_DELAUNAY_H_

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "common/core/seed.h"

namespace sprout {

/// A triangle of seeds: three indices, counter-clockwise in a frame with v upwards.
using SeedTriangle = std::array<int, 3>;

/// Delaunay triangulation of the seeds' positions (u, v) in the left image, taken to 1/64 px. Seeds
/// on one position count once: the first. Among triangulations that are equally good (four seeds on
/// a circle, as on a grid) the choice depends on the positions only, not on their order.
///
/// The only place that includes CGAL, whose 2D triangulations are under the GPL.
///
/// @returns the triangles; none for fewer than three positions or when all lie on one line.
/// O(n log n).
std::vector<SeedTriangle> TriangulateSeeds(std::span<const Seed> seeds);

/// TriangulateSeeds() for frame after frame: keeps its memory, about 200 bytes a seed, and
/// allocates nothing in steady state. One object serves one caller at a time.
class Triangulator {
 public:
  Triangulator();
  ~Triangulator();

  /// @returns as TriangulateSeeds(); valid until the next call.
  const std::vector<SeedTriangle>& Triangulate(std::span<const Seed> seeds);

  /// Of the last call: the seeds on the hull, also those on its edges; clockwise as the image is
  /// seen. None where there are no triangles.
  const std::vector<int>& hull() const { return hull_; }

 private:
  // In steps of 1/64 px.
  struct Position {
    int u;
    int v;
    int seed;
  };
  struct SortTraits;
  struct Mesh;  // CGAL's

  void TakePositions(std::span<const Seed> seeds);
  void TakeCorners();
  void Connect();
  void SplitPositions();

  std::vector<Position> positions_;
  std::vector<Position> corners_;
  std::vector<Position> early_positions_, late_positions_;
  std::unique_ptr<Mesh> mesh_;
  std::vector<SeedTriangle> triangles_;
  std::vector<int> hull_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_DELAUNAY_H_
