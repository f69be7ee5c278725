#ifndef SPROUT_SERVICES_PRIOR_DELAUNAY_H_
#define SPROUT_SERVICES_PRIOR_DELAUNAY_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/core/seed.h"
#include "services/prior/delaunay_mesh.h"

namespace sprout {

/// A triangle of seeds: three indices, counter-clockwise in a frame with v upwards.
using SeedTriangle = std::array<int, 3>;

/// Delaunay triangulation of the seeds' positions (u, v) in the left image, taken to 1/64 px. Seeds
/// on one position count once: the first. Among triangulations that are equally good (four seeds on
/// a circle, as on a grid) the choice depends on the positions only, not on their order.
///
/// @returns the triangles; none for fewer than three positions or when all lie on one line.
/// O(n log n); on OpenCV's threads, with the same result in the same order for any number.
std::vector<SeedTriangle> TriangulateSeeds(std::span<const Seed> seeds);

/// TriangulateSeeds() for frame after frame: keeps its memory, about 250 bytes a seed, and
/// allocates nothing in steady state. One object serves one caller at a time.
///
/// Many seeds are cut into strips of rows, and each strip is triangulated for itself. A triangle
/// whose circle stays clear of the other strips is one of the whole. What remains, the seam, is
/// found among few positions: the corners of all other triangles and the hulls of the strips. In
/// their triangulation
///   - a triangle with corners in two strips is one of the whole: the triangles found before lie
///     in the hulls of their strips, so it is not in their place;
///   - one with all corners in one strip is if it is one of that strip, too.
/// So the result is that of one triangulation.
class Triangulator {
 public:
  /// @returns as TriangulateSeeds(); valid until the next call.
  const std::vector<SeedTriangle>& Triangulate(std::span<const Seed> seeds);

  /// Of the last call: the seeds on the hull, also those on its edges; clockwise as the image is
  /// seen. None where there are no triangles.
  const std::vector<int>& hull() const { return hull_; }

 private:
  struct Strip {
    size_t begin = 0;  // places in positions_; none but in the first strip where these are few
    size_t end = 0;
    DelaunayMesh mesh;
    std::vector<SeedTriangle> settled;   // of the whole, too
    std::vector<MeshTriangle> doubtful;  // the others, sorted
  };

  void TakePositions(std::span<const Seed> seeds);
  void SortPositions();
  void CutIntoStrips();
  void Settle(std::span<const Seed> seeds, Strip& strip);
  bool StaysClear(const MeshTriangle& triangle, const Strip& strip) const;
  void Sew(std::span<const Seed> seeds);
  bool IsOfTheWhole(const MeshTriangle& triangle) const;
  void Add(std::span<const Seed> seeds, const MeshTriangle& triangle,
           std::vector<SeedTriangle>& triangles) const;

  std::vector<MeshPosition> positions_;  // by row and column; their ids are their places
  std::vector<MeshPosition> unsorted_;
  std::vector<int> seeds_;       // on these positions
  std::array<Strip, 2> strips_;  // four cost more than they save
  std::vector<uint8_t> is_at_seam_;
  std::vector<MeshPosition> seam_positions_;
  DelaunayMesh seam_;
  std::vector<SeedTriangle> triangles_;
  std::vector<int> hull_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_DELAUNAY_H_
