#include "services/prior/triangle_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace sprout {
namespace {

// Column at which an edge crosses a row. Both triangles of an edge see the same column, to the
// bit, since the end points are put in order first.
double CrossingColumn(const Seed& a, const Seed& b, double v) {
  const auto [top, bottom] =
      std::pair(a.v, a.u) < std::pair(b.v, b.u) ? std::pair(a, b) : std::pair(b, a);
  const double share = (v - double{top.v}) / (double{bottom.v} - double{top.v});
  return double{top.u} + share * (double{bottom.u} - double{top.u});
}

// Whole numbers in [first, last], cut to those of `range`.
std::pair<int, int> PixelsBetween(double first, double last, const cv::Range& range) {
  const auto clamp = [&](double x) {
    return static_cast<int>(std::clamp<double>(x, range.start, range.end));
  };
  return {clamp(std::ceil(first)), clamp(std::floor(last) + 1)};
}

}  // namespace

const std::vector<PixelRun>& TriangleRaster::Runs(const Seed& a, const Seed& b, const Seed& c) {
  std::array<Seed, 3> corners{a, b, c};
  std::sort(corners.begin(), corners.end(), [](const Seed& one, const Seed& other) {
    return std::pair(one.v, one.u) < std::pair(other.v, other.u);
  });
  const auto& [top, middle, bottom] = corners;
  runs_.clear();
  const auto [first_row, end_row] = PixelsBetween(top.v, bottom.v, rows_);
  for (int v = first_row; v < end_row; ++v) {
    const double row = v;
    const double long_edge = CrossingColumn(top, bottom, row);
    const double short_edge = row < double{middle.v}   ? CrossingColumn(top, middle, row)
                              : row > double{middle.v} ? CrossingColumn(middle, bottom, row)
                                                       : double{middle.u};
    const auto [left, right] = std::minmax(long_edge, short_edge);
    const auto [begin, end] = PixelsBetween(left, right, {0, width_});
    runs_.push_back({v, begin, end});
  }
  return runs_;
}

}  // namespace sprout
