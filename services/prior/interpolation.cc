#include "services/prior/interpolation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/core/parallel.h"
#include "services/prior/triangle_raster.h"

namespace sprout {
namespace {

// Disparity as a plane over the image, in whole numbers: counts with kFraction more bits. Off by
// less than a count as long as the image has fewer than 2^kFraction pixels a side.
class FixedPlane {
 public:
  FixedPlane(const Seed& a, const Seed& b, const Seed& c) : u_(Near(a.u)), v_(Near(a.v)) {
    const double bu = double{b.u} - a.u;
    const double bv = double{b.v} - a.v;
    const double cu = double{c.u} - a.u;
    const double cv = double{c.v} - a.v;
    const double bd = double{b.disparity()} - a.disparity();
    const double cd = double{c.disparity()} - a.disparity();
    const double per_area = 1 / (bu * cv - cu * bv);
    const double per_column = (bd * cv - cd * bv) * per_area;
    const double per_row = (cd * bu - bd * cu) * per_area;
    per_column_ = Fixed(per_column);
    per_row_ = Fixed(per_row);
    value_ = Fixed(a.disparity() + per_column * (u_ - double{a.u}) + per_row * (v_ - double{a.v})) +
             kHalf;
  }

  // Counts at a pixel are its value without the fraction.
  int64_t ValueAt(int u, int v) const {
    return value_ + (u - u_) * per_column_ + (v - v_) * per_row_;
  }
  int64_t per_column() const { return per_column_; }

  static constexpr int kFraction = 24;

 private:
  static constexpr int64_t kHalf = int64_t{1} << (kFraction - 1);

  static int64_t Fixed(double disparity_px) {
    constexpr double kLargestPx = 1e5;  // steep slivers; their rows are a pixel long
    constexpr double kScale = double{DisparityImage::kCountsPerPixel} * (int64_t{1} << kFraction);
    return static_cast<int64_t>(std::clamp(disparity_px, -kLargestPx, kLargestPx) * kScale);
  }

  // A pixel near a corner: from there rounding errors grow.
  static int Near(float position) { return static_cast<int>(std::clamp(position, 0.F, 32767.F)); }

  int u_;
  int v_;
  int64_t per_column_;
  int64_t per_row_;
  int64_t value_;  // at (u_, v_), and a half for rounding
};

// Neighbours both paint their common edge, with the same values but for rounding.
void PaintTriangle(const Seed& a, const Seed& b, const Seed& c, const cv::Range& rows,
                   DisparityImage& map) {
  const TriangleRaster raster(a, b, c, map.width(), rows);
  if (raster.end_row() <= raster.first_row()) return;
  const FixedPlane plane(a, b, c);
  const auto [least, most] = std::minmax({a.disparity(), b.disparity(), c.disparity()});
  const int64_t least_counts = ToCounts(least);
  const int64_t most_counts = ToCounts(most);
  for (int v = raster.first_row(); v < raster.end_row(); ++v) {
    const PixelRun run = raster.Run(v);
    int16_t* const counts = map.counts()[run.v];
    const auto at = [&](int u) { return plane.ValueAt(u, run.v) >> FixedPlane::kFraction; };
    const auto [low, high] = std::minmax({at(run.begin), at(run.end - 1)});
    int64_t value = plane.ValueAt(run.begin, run.v);
    if (least_counts <= low && high <= most_counts) {
      for (int u = run.begin; u < run.end; ++u, value += plane.per_column()) {
        counts[u] = static_cast<int16_t>(value >> FixedPlane::kFraction);
      }
      continue;
    }
    // Rounding must not carry a pixel in a sliver beyond its corners.
    for (int u = run.begin; u < run.end; ++u, value += plane.per_column()) {
      counts[u] = static_cast<int16_t>(
          std::clamp(value >> FixedPlane::kFraction, least_counts, most_counts));
    }
  }
}

// Outside the hull: the value of the nearest pixel that has one.
void ExtendBeyondHull(const Hull& hull, DisparityImage& map) {
  const std::vector<PixelRun>& runs = hull.runs();
  ForEachParallel(static_cast<size_t>(map.height()), [&](size_t index) {
    const auto v = static_cast<int>(index);
    const size_t row = hull.AtOrBelow(v);
    const PixelRun own = runs[row].v == v ? runs[row] : PixelRun{v, map.width(), map.width()};
    size_t run = row;
    for (int u = 0; u < map.width(); ++u) {
      if (u == own.begin) u = own.end;
      if (u == map.width()) break;
      run = hull.Nearest(u, v, run);
      map.counts()(v, u) = map.counts()(runs[run].v, Hull::NearestColumn(u, runs[run]));
    }
  });
}

}  // namespace

Result<DisparityImage> InterpolateSeeds(std::span<const Seed> seeds,
                                        std::span<const SeedTriangle> triangles, cv::Size size,
                                        DisparityImage map) {
  return SeedInterpolator().Interpolate(seeds, triangles, size, std::move(map));
}

Result<DisparityImage> SeedInterpolator::Interpolate(std::span<const Seed> seeds,
                                                     std::span<const SeedTriangle> triangles,
                                                     cv::Size size, DisparityImage map) {
  if (seeds.size() < 3) {
    return Fail(std::to_string(seeds.size()) + " seeds: a prior needs at least 3");
  }
  if (triangles.empty()) {
    return Fail(std::to_string(seeds.size()) + " seeds, all on one line: no prior");
  }
  const auto corners = [&](const SeedTriangle& triangle) {
    const auto seed = [&](size_t i) { return seeds[static_cast<size_t>(triangle[i])]; };
    return std::array{seed(0), seed(1), seed(2)};
  };
  reach_.resize(triangles.size());
  ForEachParallel(triangles.size(), [&](size_t i) {
    const auto [a, b, c] = corners(triangles[i]);
    reach_[i] = ReachOf(a, b, c);
  });
  map.counts().create(size);
  PaintInBands(size.height, [&](const cv::Range& rows) {
    Clear(map, rows);
    for (size_t i = 0; i < triangles.size(); ++i) {
      if (!reach_[i].Meets(rows)) continue;
      const auto [a, b, c] = corners(triangles[i]);
      PaintTriangle(a, b, c, rows, map);
    }
  });
  hull_.Find(map);
  if (hull_.runs().empty()) return Fail("the seeds' triangles cover no pixel: no prior");
  ExtendBeyondHull(hull_, map);
  return map;
}

}  // namespace sprout
