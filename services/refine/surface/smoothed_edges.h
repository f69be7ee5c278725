#pragma once

#include <vector>

#include "common/geometry/projection.h"
#include "services/refine/surface/tof_surface.h"

namespace sprout::refine {

/// A range image that was smoothed across depth edges.
struct Smoothing {
  /// How wide its edges are, ToF pixels: a quarter of them, steps of one sign side by side along a
  /// row or a column, are at most so many times as high as their highest step. A Gaussian of σ
  /// makes 2.5 σ of it. 0: they are sharp, or too few to tell.
  double edge_width = 0;
  double dropped_share = 0;  ///< of the points, 0 to 1

  explicit operator bool() const { return edge_width > 0; }
};

/// Drops the points beside the edges of a smoothed range image: a point is dropped if along rows,
/// columns or diagonals another one, no farther than the edges are wide, lies off its plane.
/// @param points  those that the surface was made of; in a sharp image all stay.
/// O(ToF pixels), in a smoothed image O(ToF pixels · width). No I/O; one thread.
Smoothing DropSmoothed(const TofSurface& surface, std::vector<ProjectedPoint>& points);

}  // namespace sprout::refine
