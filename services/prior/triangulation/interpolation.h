#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <opencv2/core.hpp>
#include <span>
#include <utility>
#include <vector>

#include "common/core/prior_map.h"
#include "common/core/result.h"
#include "services/prior/edges/seed_planes.h"

namespace sprout::prior {

/// The planes at the corners of a triangle.
using Corners = std::array<Plane, 3>;

inline Corners CornersOf(std::span<const Plane> planes, const SeedTriangle& triangle) {
  const auto plane = [&](size_t i) { return planes[static_cast<size_t>(triangle[i])]; };
  return {plane(0), plane(1), plane(2)};
}

/// Triangles by bands of rows of an image: a band is painted at a time, by one thread, and stays in
/// its cache. Triangles keep their order, so that the image is the same with any number of threads.
class TrianglesByBand {
 public:
  /// Rows of a band; the last has fewer. Disparity and σ of a band of 2000 columns are 400 KB.
  static constexpr int kRows = 64;

  /// @param triangle_at  triangle_at(i), i < count: a SeedTriangle.
  template <typename TriangleAt>
  TrianglesByBand(std::span<const Plane> planes, size_t count, const TriangleAt& triangle_at,
                  int height);

  int size() const { return static_cast<int>(first_.size()) - 1; }

  cv::Range RowsOf(int band) const { return {band * kRows, std::min((band + 1) * kRows, height_)}; }

  /// The triangles that may have pixels in a band: their numbers, rising.
  std::span<const int> TrianglesOf(int band) const {
    const auto at = static_cast<size_t>(band);
    return std::span(triangles_).subspan(first_[at], first_[at + 1] - first_[at]);
  }

 private:
  int height_;
  std::vector<size_t> first_;  // in triangles_, of each band; one more than bands
  std::vector<int> triangles_;
};

/// Runs reach this far beyond a triangle's sides, px, so that rounding never leaves out a pixel
/// between triangles.
inline constexpr double kSideSlack = 1.0 / (1 << 16);
/// px a row. Steeper sides cross less than a row.
inline constexpr double kSteepestSide = 1 << 20;

/// The sides of a triangle: from its top to its bottom, and both by way of its middle.
struct Sides {
  /// @param corners  must outlive this object.
  /// @param rows     of the image.
  Sides(const Corners& corners, const cv::Range& rows)
      : top(corners.data()), middle(top + 1), bottom(top + 2) {
    const auto order = [](const Plane*& a, const Plane*& b) {
      if (b->v < a->v) std::swap(a, b);
    };
    order(top, middle);
    order(middle, bottom);
    order(top, middle);
    const auto slope = [](const Plane& a, const Plane& b) {
      const double height = double{b.v} - a.v;
      return height > 0 ? std::clamp((double{b.u} - a.u) / height, -kSteepestSide, kSteepestSide)
                        : 0;
    };
    long_slope = slope(*top, *bottom);
    upper_slope = slope(*top, *middle);
    lower_slope = slope(*middle, *bottom);
    // Compared before they are converted: seeds may lie anywhere.
    first = static_cast<int>(std::ceil(std::clamp<double>(top->v, rows.start, rows.end)));
    end = static_cast<int>(std::clamp<double>(
        std::floor(std::clamp<double>(bottom->v, -2, rows.end)) + 1, first, rows.end));
  }

  const Plane *top, *middle, *bottom;
  double long_slope, upper_slope, lower_slope;  ///< px a row
  int first, end;                               ///< rows of the image that it crosses
};

/// Calls paint(v, begin, end) for the pixels of an image whose centre lies in a triangle or on its
/// border: columns [begin, end) of row v. Neighbouring triangles both have the pixels of their
/// common side, so that none between them is missed.
/// @param rows  of the image; others are left out.
template <typename Paint>
void ForEachRun(const Corners& corners, int width, const cv::Range& rows, const Paint& paint);

/// Paints a prior: linear interpolation of the planes' disparities in each triangle (paper, Alg. 1
/// step 1), and its standard deviation, eq. (P8) of the README. Pixels in no triangle get the
/// disparity of the nearest painted pixel of their row (in a row without any, that of the nearest
/// row) and the standard deviation kMaxSigmaCounts.
///
/// @param planes     at the triangles' corners.
/// @param triangles  where they overlap, the last one is painted.
/// @param edge_px    planes that are at least this far apart belong to two surfaces.
/// @param map        memory of the map's size, overwritten.
/// @returns an error that says why when no triangle covers a pixel.
/// O(triangles + pixels); on OpenCV's threads, with the same result for any number.
Result<void> Interpolate(std::span<const Plane> planes, std::span<const SeedTriangle> triangles,
                         double edge_px, PriorMap& map);

template <typename TriangleAt>
TrianglesByBand::TrianglesByBand(std::span<const Plane> planes, size_t count,
                                 const TriangleAt& triangle_at, int height)
    : height_(height), first_(static_cast<size_t>((height + kRows - 1) / kRows) + 2, 0) {
  const auto bands = static_cast<double>(first_.size() - 2);
  const auto for_each_band = [&](size_t i, const auto& act) {
    const SeedTriangle& triangle = triangle_at(i);
    const auto v = [&](size_t k) { return planes[static_cast<size_t>(triangle[k])].v; };
    const auto [least, most] = std::minmax({v(0), v(1), v(2)});
    // Clamped before they are converted: seeds may lie anywhere.
    const auto begin = static_cast<size_t>(std::clamp(double{least} / kRows, 0.0, bands));
    const auto end = static_cast<size_t>(std::clamp(double{most} / kRows + 1, 0.0, bands));
    for (size_t band = begin; band < end; ++band) act(band);
  };
  for (size_t i = 0; i < count; ++i) {
    for_each_band(i, [&](size_t band) { ++first_[band + 2]; });
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  triangles_.resize(first_.back());
  for (size_t i = 0; i < count; ++i) {  // moves first_[band + 1] to the band's end
    for_each_band(i, [&](size_t band) { triangles_[first_[band + 1]++] = static_cast<int>(i); });
  }
  first_.pop_back();
}

template <typename Paint>
void ForEachRun(const Corners& corners, int width, const cv::Range& rows, const Paint& paint) {
  const Sides sides(corners, rows);
  const auto& [top, middle, bottom, long_slope, upper_slope, lower_slope, first, end] = sides;
  for (int v = first; v < end; ++v) {
    const double one = top->u + (v - double{top->v}) * long_slope;
    const double other = v < double{middle->v} ? top->u + (v - double{top->v}) * upper_slope
                                               : middle->u + (v - double{middle->v}) * lower_slope;
    // The next column to the right of what is given.
    const auto behind = [&](double column) {
      return static_cast<int>(std::clamp<double>(column, -1, width - 1) + 1);
    };
    const auto [left, right] = std::minmax(one, other);
    const int begin_column = behind(left - kSideSlack);
    const int end_column = behind(right + kSideSlack);
    if (begin_column < end_column) paint(v, begin_column, end_column);
  }
}

/// Paints the chosen triangles into some rows of a prior, later ones over earlier ones: eqs. (P4)
/// and (P8) at the pixels of ForEachRun(). Computes several rows of a triangle, and several pixels
/// of a run, at once, with the same bytes on every CPU. O(triangles + pixels).
void PaintTriangles(std::span<const Plane> planes, std::span<const SeedTriangle> triangles,
                    std::span<const int> chosen, double edge_px, const cv::Range& rows,
                    PriorMap& map);

}  // namespace sprout::prior
