#include "services/prior/triangle_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace sprout {
namespace {

// Columns in fixed point: px with that many more bits. For images of up to 2^14 px a side nothing
// overflows, and rounded slopes are off by less than kSlack over all rows.
constexpr int kMostRows = 1 << 14;
constexpr int kFraction = 32;
constexpr int64_t kOne = int64_t{1} << kFraction;
// Runs reach that much beyond their edges, so that rounding never leaves a pixel between triangles.
constexpr int64_t kSlack = kOne >> 16;

int64_t Fixed(double px, double most_px) {
  return static_cast<int64_t>(std::clamp(px, -most_px, most_px) * static_cast<double>(kOne));
}

// Where an edge of a triangle crosses rows.
class Edge {
 public:
  Edge(const Seed& top, const Seed& bottom) {
    const double height = double{bottom.v} - top.v;
    const double slope = height > 0 ? (double{bottom.u} - top.u) / height : 0;
    const double first_row = std::ceil(std::clamp<double>(top.v, 0, kMostRows));
    first_row_ = static_cast<int>(first_row);
    column_ = Fixed(top.u + (first_row - top.v) * slope, 1 << 24);
    slope_ = Fixed(slope, 1 << 14);  // a steeper one crosses a single row
  }

  int64_t ColumnAt(int row) const { return column_ + (row - first_row_) * slope_; }

 private:
  int first_row_;  // of those in images
  int64_t column_;
  int64_t slope_;
};

}  // namespace

RowReach ReachOf(const Seed& a, const Seed& b, const Seed& c) {
  const auto [least, most] = std::minmax({a.v, b.v, c.v});
  constexpr auto kLast = static_cast<float>(kMostRows - 1);
  return {static_cast<int16_t>(std::clamp(least, 0.F, kLast)),
          static_cast<int16_t>(std::clamp(most, -1.F, kLast) + 1)};
}

const std::vector<PixelRun>& TriangleRaster::Runs(const Seed& a, const Seed& b, const Seed& c) {
  runs_.clear();
  std::array<Seed, 3> corners{a, b, c};
  const auto order = [](Seed& one, Seed& other) {
    if (std::pair(other.v, other.u) < std::pair(one.v, one.u)) std::swap(one, other);
  };
  order(corners[0], corners[1]);
  order(corners[1], corners[2]);
  order(corners[0], corners[1]);
  const auto& [top, middle, bottom] = corners;
  const Edge long_edge(top, bottom);
  const Edge upper_edge(top, middle);
  const Edge lower_edge(middle, bottom);
  const auto pixel = [&](int64_t column) {
    return static_cast<int>(std::clamp<int64_t>(column >> kFraction, 0, width_));
  };
  const int first_row = static_cast<int>(std::ceil(std::max<double>(top.v, rows_.start)));
  const double end_row = std::min<double>(std::floor(bottom.v) + 1, rows_.end);
  for (int v = first_row; v < end_row; ++v) {
    const Edge& short_edge = static_cast<float>(v) < middle.v ? upper_edge : lower_edge;
    const int64_t one = long_edge.ColumnAt(v);
    const int64_t other = short_edge.ColumnAt(v);
    runs_.push_back({v, pixel(std::min(one, other) - kSlack + kOne - 1),
                     pixel(std::max(one, other) + kSlack + kOne)});
  }
  return runs_;
}

}  // namespace sprout
