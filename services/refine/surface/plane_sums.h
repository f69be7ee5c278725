#pragma once

#include <opencv2/core.hpp>

namespace sprout::refine {

/// Weighted sums over places (x, y) around an origin, for the least-squares slope of a quantity d
/// that is 0 there.
struct SlopeSums {
  double xx, xy = 0, yy, xd = 0, yd = 0;

  /// @param regular  a weight for level slopes: keeps them finite where all places lie in a line.
  explicit SlopeSums(double regular) : xx(regular), yy(regular) {}

  void Add(double weight, double x, double y, double d) {
    xx += weight * x * x;
    xy += weight * x * y;
    yy += weight * y * y;
    xd += weight * x * d;
    yd += weight * y * d;
  }

  double Determinant() const { return xx * yy - xy * xy; }
  /// How d rises along x and along y.
  cv::Point2d Slope() const { return SlopeOf(xd, yd); }
  /// The same of another quantity. @param of_x, of_y  its sums in the place of xd and yd.
  cv::Point2d SlopeOf(double of_x, double of_y) const {
    const double determinant = Determinant();
    return {(yy * of_x - xy * of_y) / determinant, (xx * of_y - xy * of_x) / determinant};
  }
};

/// The same for the least-squares plane of a quantity d that need not be 0 at the origin.
struct PlaneSums {
  double n = 0, x = 0, y = 0, d = 0;
  SlopeSums slopes;

  explicit PlaneSums(double regular) : slopes(regular) {}

  void Add(double weight, double at_x, double at_y, double at) {
    n += weight;
    x += weight * at_x;
    y += weight * at_y;
    d += weight * at;
    slopes.Add(weight, at_x, at_y, at);
  }
};

}  // namespace sprout::refine
