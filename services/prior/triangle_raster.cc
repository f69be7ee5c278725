#include "services/prior/triangle_raster.h"

#include <array>
#include <cmath>
#include <utility>

namespace sprout {

RowReach ReachOf(const Seed& a, const Seed& b, const Seed& c) {
  const auto [least, most] = std::minmax({a.v, b.v, c.v});
  constexpr auto kLast = static_cast<float>(kLargestSide - 1);
  return {static_cast<int16_t>(std::clamp(least, 0.F, kLast)),
          static_cast<int16_t>(std::clamp(most, -1.F, kLast) + 1)};
}

void Clear(DisparityImage& map, const cv::Range& rows) {
  for (int v = rows.start; v < rows.end; ++v) {
    int16_t* const row = map.counts()[v];
    if (v == rows.start) {
      std::fill_n(row, map.width(), DisparityImage::kInvalid);
    } else {
      std::copy_n(map.counts()[rows.start], map.width(), row);  // many pixels at once
    }
  }
}

inline int64_t TriangleRaster::Edge::Fixed(double px, double most_px) {
  return static_cast<int64_t>(std::clamp(px, -most_px, most_px) * static_cast<double>(kOne));
}

inline TriangleRaster::Edge::Edge(const Seed& top, const Seed& bottom) {
  const double height = double{bottom.v} - top.v;
  const double slope = height > 0 ? (double{bottom.u} - top.u) / height : 0;
  const double first_row = std::ceil(std::clamp<double>(top.v, 0, kLargestSide));
  first_row_ = static_cast<int>(first_row);
  column_ = Fixed(top.u + (first_row - top.v) * slope, 1 << 24);
  slope_ = Fixed(slope, kLargestSide);  // a steeper one crosses a single row
}

TriangleRaster::TriangleRaster(const Seed& a, const Seed& b, const Seed& c, int width,
                               const cv::Range& rows)
    : width_(width) {
  std::array<Seed, 3> corners{a, b, c};
  const auto order = [](Seed& one, Seed& other) {
    if (std::pair(other.v, other.u) < std::pair(one.v, one.u)) std::swap(one, other);
  };
  order(corners[0], corners[1]);
  order(corners[1], corners[2]);
  order(corners[0], corners[1]);
  const auto& [top, middle, bottom] = corners;
  // Compared before they are converted: seeds may lie anywhere.
  first_row_ = static_cast<int>(std::ceil(std::clamp<double>(top.v, rows.start, rows.end)));
  const double end_row = std::min<double>(std::floor(bottom.v) + 1, rows.end);
  end_row_ = static_cast<int>(std::max<double>(end_row, rows.start));
  if (end_row_ <= first_row_) return;
  long_edge_ = Edge(top, bottom);
  upper_edge_ = Edge(top, middle);
  lower_edge_ = Edge(middle, bottom);
  middle_v_ = middle.v;
}

}  // namespace sprout
