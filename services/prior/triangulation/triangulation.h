#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "common/core/seed.h"

namespace sprout::prior {

/// A triangle of seeds: three indices, counter-clockwise in a frame with v upwards.
using SeedTriangle = std::array<int, 3>;

/// The Delaunay triangulation of the seeds' positions (u, v) in the left image.
struct Triangulation {
  std::vector<SeedTriangle> triangles;
  /// The seeds on the convex hull, also those on its sides; clockwise as the image is seen. None
  /// where there are no triangles.
  std::vector<int> hull;

  /// The seeds that share a side of a triangle with a seed, each once.
  std::span<const int> NeighboursOf(int seed) const {
    const auto [begin, size] = lists[static_cast<size_t>(seed)];
    return std::span(neighbours).subspan(begin, size);
  }

  struct List {
    size_t begin = 0;
    size_t size = 0;
  };
  std::vector<List> lists;      ///< one a seed
  std::vector<int> neighbours;  ///< all lists, one behind the other
};

/// Of several seeds at one position only the first is used; the others have no triangle and no
/// neighbour. Where several Delaunay triangulations exist (four seeds on a circle, as on a grid),
/// the choice depends on the positions only, and so does the order of triangles, hull and
/// neighbours.
///
/// @param seeds  finite.
/// @returns no triangles for fewer than three positions, or when all lie on one line.
/// O(n log n); on OpenCV's threads but for what CGAL does, with the same result for any number.
/// CGAL's 2D triangulations are under the GPL.
Triangulation Triangulate(std::span<const Seed> seeds);

/// The seeds around some, ring by ring: their neighbours, the neighbours of those, and so on. One
/// object serves one thread at a time.
class Rings {
 public:
  /// @param triangulation  must outlive this object. O(seeds).
  explicit Rings(const Triangulation& triangulation)
      : triangulation_(triangulation), found_in_(triangulation.lists.size(), 0) {}

  /// @param seeds  come first in the answer; those that are not in the triangulation are left out.
  /// @param most   largest number of seeds in the answer.
  /// @returns each seed once, nearer rings first; valid until the next call.
  std::span<const int> Around(std::span<const int> seeds, int rings, size_t most);

 private:
  void Add(int seed);

  const Triangulation& triangulation_;
  std::vector<int> found_in_;  // the last call that found a seed
  int call_ = 0;
  std::vector<int> found_;
};

}  // namespace sprout::prior
