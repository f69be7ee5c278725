#include "services/prior/interpolation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string>
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
void PaintTriangle(const Seed& a, const Seed& b, const Seed& c, TriangleRaster& raster,
                   DisparityImage& map) {
  const std::vector<PixelRun>& runs = raster.Runs(a, b, c);
  if (runs.empty()) return;
  const FixedPlane plane(a, b, c);
  const auto [least, most] = std::minmax({a.disparity(), b.disparity(), c.disparity()});
  const int64_t least_counts = ToCounts(least);
  const int64_t most_counts = ToCounts(most);
  for (const PixelRun& run : runs) {
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

// The pixels of the hull: one run in each row that has any.
class Hull {
 public:
  explicit Hull(const DisparityImage& map) {
    for (int v = 0; v < map.height(); ++v) {
      const int16_t* const begin = map.counts()[v];
      const int16_t* const end = begin + map.width();
      const auto valid = [](int16_t counts) { return counts != DisparityImage::kInvalid; };
      const int16_t* const first = std::find_if(begin, end, valid);
      if (first == end) continue;
      const auto last =
          std::find_if(std::reverse_iterator(end), std::reverse_iterator(first), valid);
      runs_.push_back({v, static_cast<int>(first - begin), static_cast<int>(last.base() - begin)});
      left_.push_back(runs_.back().begin);
      right_.push_back(runs_.back().end - 1);
    }
    // Rounding to pixels made dents of less than one, in which Nearest() would get stuck.
    FillDents(left_, -1);
    FillDents(right_, 1);
  }

  const std::vector<PixelRun>& runs() const { return runs_; }

  // The run in a row, or the next below, or the last.
  size_t AtOrBelow(int v) const {
    const auto run = std::lower_bound(runs_.begin(), runs_.end(), v,
                                      [](const PixelRun& one, int row) { return one.v < row; });
    return std::min(static_cast<size_t>(run - runs_.begin()), runs_.size() - 1);
  }

  // The run with the pixel that is nearest to (u, v), within a pixel, by steps downhill from the
  // one at `run`: the distance of a point to the rows of a convex shape has one minimum.
  size_t Nearest(int u, int v, size_t run) const {
    double distance = SquaredDistance(u, v, run);
    const auto descend = [&](size_t step) {
      for (size_t next = run + step; next < runs_.size(); next += step) {
        const double there = SquaredDistance(u, v, next);
        if (there >= distance) break;
        distance = there;
        run = next;
      }
    };
    descend(1);
    descend(size_t{0} - 1);
    return run;
  }

  static int NearestColumn(int u, const PixelRun& run) {
    return std::clamp(u, run.begin, run.end - 1);
  }

 private:
  // Moves columns outwards, which is in the direction of `sign`, onto their convex chain.
  void FillDents(std::vector<double>& columns, double sign) const {
    const auto slope = [&](size_t from, size_t to) {
      return (columns[to] - columns[from]) / (runs_[to].v - runs_[from].v) * sign;
    };
    std::vector<size_t> chain;
    for (size_t i = 0; i < columns.size(); ++i) {
      const auto is_dent = [&](size_t before, size_t at) {
        return slope(before, at) <= slope(at, i);
      };
      while (chain.size() >= 2 && is_dent(chain.end()[-2], chain.back())) chain.pop_back();
      chain.push_back(i);
    }
    for (size_t link = 1; link < chain.size(); ++link) {
      const size_t from = chain[link - 1];
      const double per_row = slope(from, chain[link]) * sign;
      for (size_t i = from + 1; i < chain[link]; ++i) {
        columns[i] = columns[from] + per_row * (runs_[i].v - runs_[from].v);
      }
    }
  }

  double SquaredDistance(int u, int v, size_t run) const {
    const double across = u - std::clamp<double>(u, left_[run], right_[run]);
    const double down = v - runs_[run].v;
    return across * across + down * down;
  }

  std::vector<PixelRun> runs_;
  std::vector<double> left_;  // first and last column of each run, and a little more
  std::vector<double> right_;
};

// Outside the hull: the value of the nearest pixel that has one.
void ExtendBeyondHull(const Hull& hull, DisparityImage& map) {
  const std::vector<PixelRun>& runs = hull.runs();
  PaintInBands(map.height(), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      const size_t row = hull.AtOrBelow(v);
      const PixelRun own = runs[row].v == v ? runs[row] : PixelRun{v, map.width(), map.width()};
      size_t run = row;
      for (int u = 0; u < map.width(); ++u) {
        if (u == own.begin) u = own.end;
        if (u == map.width()) break;
        run = hull.Nearest(u, v, run);
        map.counts()(v, u) = map.counts()(runs[run].v, Hull::NearestColumn(u, runs[run]));
      }
    }
  });
}

}  // namespace

Result<DisparityImage> InterpolateSeeds(std::span<const Seed> seeds,
                                        std::span<const SeedTriangle> triangles, cv::Size size,
                                        DisparityImage map) {
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
  std::vector<RowReach> reach;
  reach.reserve(triangles.size());
  for (const SeedTriangle& triangle : triangles) {
    const auto [a, b, c] = corners(triangle);
    reach.push_back(ReachOf(a, b, c));
  }
  map.counts().create(size);
  PaintInBands(size.height, [&](const cv::Range& rows) {
    map.counts().rowRange(rows).setTo(DisparityImage::kInvalid);
    TriangleRaster raster(size.width, rows);
    for (size_t i = 0; i < triangles.size(); ++i) {
      if (!reach[i].Meets(rows)) continue;
      const auto [a, b, c] = corners(triangles[i]);
      PaintTriangle(a, b, c, raster, map);
    }
  });
  const Hull hull(map);
  if (hull.runs().empty()) return Fail("the seeds' triangles cover no pixel: no prior");
  ExtendBeyondHull(hull, map);
  return map;
}

}  // namespace sprout
