#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sprout::prior {

/// A seed as the triangulation sees it.
struct GridPoint {
  float u, v;            ///< position in the left image, px
  int16_t tof_u, tof_v;  ///< its pixel in the ToF image; −1: none
};

/// Triangles of a Delaunay triangulation that can be told without building it: "a 2D triangulation
/// applied to the TOF image" (paper, Alg. 1 step 1), where that is Delaunay's.
///
/// A cell is four neighbouring pixels of the ToF image. It is *intact* if it has four points that
/// make two triangles whose circles have no other point in or near them. These are in every
/// Delaunay triangulation of the points. Where the grid has holes, folds at a depth edge, or has
/// four points on one circle, cells are not intact.
class GridCells {
 public:
  /// A triangle of the fan around a point; counter-clockwise: the point, from, to.
  struct FanTriangle {
    int from, to;
  };

  /// @param points  each position once; must outlive the object. Numbers here are places in it.
  /// Usually O(points), never more than O(100 points); on OpenCV's threads, with the same result
  /// for any number.
  explicit GridCells(std::span<const GridPoint> points);

  /// Whether any cell is intact.
  bool AnyIntact() const { return any_intact_; }

  /// Whether all four cells around a point are intact: its triangles are known.
  bool IsInside(int point) const;

  /// Appends the triangles at a point in intact cells; counter-clockwise where IsInside().
  void AddFan(int point, std::vector<FanTriangle>& fan) const;

  /// Whether a triangle of an intact cell lies to the left of the way from one point to another:
  /// (from, to, third) is counter-clockwise.
  bool HasTriangle(int from, int to) const;

 private:
  /// How a cell is divided: its corners are a = (x, y), b = (x + 1, y), c = (x, y + 1), d = (x + 1,
  /// y + 1).
  enum Diagonal : uint8_t { kNotIntact, kFromAToD, kFromBToC };

  void FindColumnsAndRows();
  Diagonal DiagonalOf(int x, int y, const class PointsByCell& near) const;
  Diagonal At(int x, int y) const;
  int PointAt(int x, int y) const;

  std::span<const GridPoint> points_;
  int columns_ = 0;  // of ToF pixels
  int rows_ = 0;
  std::vector<int> point_at_;        // by ToF pixel; −1 without one
  std::vector<Diagonal> diagonals_;  // by the pixel of corner a
  bool any_intact_ = false;
};

}  // namespace sprout::prior
