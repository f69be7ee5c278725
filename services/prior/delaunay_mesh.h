#ifndef SPROUT_SERVICES_PRIOR_DELAUNAY_MESH_H_
#define SPROUT_SERVICES_PRIOR_DELAUNAY_MESH_H_

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace sprout {

/// A position in an image, in whole steps, and a number to know it by.
struct MeshPosition {
  int u;
  int v;
  int id;
};

/// The ids of three positions, counter-clockwise in a frame with v upwards.
using MeshTriangle = std::array<int, 3>;

/// Delaunay triangulation of positions. Where several are equally good (four positions on a circle,
/// as on a grid) it takes one that does not depend on the order of positions, nor on how far others
/// are: a triangle with nothing in its circle stays one when positions outside are added or taken
/// away.
///
/// The only place that includes CGAL, whose 2D triangulations are under the GPL. Keeps its memory,
/// about 200 bytes a position, and allocates nothing in steady state. One object serves one caller
/// at a time.
class DelaunayMesh {
 public:
  DelaunayMesh();
  ~DelaunayMesh();

  /// Coordinates between these.
  static constexpr int kFarthest = 1 << 28;

  /// @param positions  ordered by v, then by u; no two the same.
  /// O(n log n).
  void Triangulate(std::span<const MeshPosition> positions);

  /// Of the last call; none for fewer than three positions or when all lie on one line.
  const std::vector<MeshTriangle>& triangles() const { return triangles_; }

  /// Of the last call: the positions on the hull, also those on its edges; clockwise as the image
  /// is seen. Where there are no triangles, all positions.
  const std::vector<int>& hull() const { return hull_; }

 private:
  struct SortTraits;
  struct Cgal;

  void TakeCorners();
  void Connect();

  std::vector<MeshPosition> positions_;
  std::vector<MeshPosition> corners_;
  std::unique_ptr<Cgal> cgal_;
  std::vector<MeshTriangle> triangles_;
  std::vector<int> hull_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_DELAUNAY_MESH_H_
