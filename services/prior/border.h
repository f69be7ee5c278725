#ifndef SPROUT_SERVICES_PRIOR_BORDER_H_
#define SPROUT_SERVICES_PRIOR_BORDER_H_

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "services/prior/delaunay.h"
#include "services/prior/seed_surface.h"

namespace sprout {

/// Continues the surface of the seeds from their hull towards the borders of the image, where there
/// are no seeds to interpolate between: every seed of the hull comes again straight across at the
/// border, on its own plane, and triangles fill the space between. Not further than some reach,
/// since a plane far from its seeds is a guess. So slanted surfaces go on
/// slanted, and depth edges that leave the hull are looked for there like inside it.
///
/// Keeps its memory from frame to frame, so one object serves one caller at a time.
class BorderExtender {
 public:
  struct Extended {
    SeedSurface surface;                  ///< the given one, and behind it planes at the borders
    std::vector<SeedTriangle> triangles;  ///< the given ones, and behind them those at the borders
  };

  /// @param triangles  of the surface's seeds.
  /// @param hull       Triangulator::hull() of these; empty: nothing is added.
  /// @param size       of the left image, px.
  /// @param reach_px   how far surfaces go on at most, across and down.
  /// @returns valid until the next call. O(seeds).
  const Extended& Extend(const SeedSurface& surface, std::span<const SeedTriangle> triangles,
                         std::span<const int> hull, cv::Size size, double reach_px);

 private:
  enum Side { kTop, kRight, kBottom, kLeft };  // in the order of the hull
  static Side Beyond(const LocalPlane& a, const LocalPlane& b);
  struct Direction {
    int columns;
    int rows;
  };
  static Direction DirectionOf(Side side);
  static Side Next(Side side) { return static_cast<Side>((side + 1) % 4); }

  const LocalPlane& PlaneOf(int seed) const {
    return extended_.surface.planes[static_cast<size_t>(seed)];
  }
  int AddPlane(int seed, float u, float v);
  int AddAtBorder(int seed, Direction towards);
  void AddTriangle(int a, int b, int c);
  void FillAcross(int a, int b, Side side);
  void FillCorners(int seed, Side from, Side to);

  float reach_px_ = 0;
  float last_column_ = 0;
  float last_row_ = 0;
  Extended extended_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_BORDER_H_
