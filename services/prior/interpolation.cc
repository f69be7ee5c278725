#include "services/prior/interpolation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "services/prior/triangle_raster.h"

namespace sprout {
namespace {

// Disparity as a plane over the image: d(u, v) = at_origin + u·per_column + v·per_row.
struct Plane {
  double at_origin;
  double per_column;
  double per_row;
};

Plane PlaneThrough(const Seed& a, const Seed& b, const Seed& c) {
  const double bu = double{b.u} - a.u;
  const double bv = double{b.v} - a.v;
  const double cu = double{c.u} - a.u;
  const double cv = double{c.v} - a.v;
  const double bd = double{b.disparity()} - a.disparity();
  const double cd = double{c.disparity()} - a.disparity();
  const double area = bu * cv - cu * bv;
  const double per_column = (bd * cv - cd * bv) / area;
  const double per_row = (cd * bu - bd * cu) / area;
  return {a.disparity() - per_column * a.u - per_row * a.v, per_column, per_row};
}

// Disparities along a row of a plane, in whole numbers: counts with kFraction more bits. Off by
// less than a count as long as the row has fewer than 2^kFraction pixels.
class RowOfPlane {
 public:
  RowOfPlane(const Plane& plane, int u, int v)
      : value_(Fixed(plane.at_origin + plane.per_column * u + plane.per_row * v) + kHalf),
        step_(Fixed(plane.per_column)) {}

  // Counts at the next pixel, rounded to nearest.
  int64_t Next() {
    const int64_t counts = value_ >> kFraction;
    value_ += step_;
    return counts;
  }

 private:
  static constexpr int kFraction = 24;
  static constexpr int64_t kHalf = int64_t{1} << (kFraction - 1);

  static int64_t Fixed(double disparity_px) {
    constexpr double kLargestPx = 1e5;  // steep slivers; their rows are a pixel long
    constexpr double kScale = double{DisparityImage::kCountsPerPixel} * (int64_t{1} << kFraction);
    return std::llround(std::clamp(disparity_px, -kLargestPx, kLargestPx) * kScale);
  }

  int64_t value_;
  int64_t step_;
};

// Neighbours both paint their common edge, with the same values but for rounding.
void PaintTriangle(const Seed& a, const Seed& b, const Seed& c, TriangleRaster& raster,
                   DisparityImage& map) {
  const std::vector<PixelRun>& runs = raster.Runs(a, b, c);
  if (runs.empty()) return;
  const Plane plane = PlaneThrough(a, b, c);
  // Rounding must not carry a pixel in a sliver beyond its corners.
  const auto [least, most] = std::minmax({a.disparity(), b.disparity(), c.disparity()});
  const int64_t least_counts = ToCounts(least);
  const int64_t most_counts = ToCounts(most);
  for (const PixelRun& run : runs) {
    int16_t* const counts = map.counts()[run.v];
    RowOfPlane row(plane, run.begin, run.v);
    for (int u = run.begin; u < run.end; ++u) {
      counts[u] = static_cast<int16_t>(std::clamp(row.Next(), least_counts, most_counts));
    }
  }
}

// Outside the hull: the value of the nearest pixel that has one.
void ExtendBeyondHull(DisparityImage& map) {
  cv::Mat1b outside;
  cv::compare(map.counts(), DisparityImage::kInvalid, outside, cv::CMP_EQ);
  if (cv::countNonZero(outside) == 0) return;
  cv::Mat1f distance;
  cv::Mat1i label;  // every pixel with a value has a label of its own
  cv::distanceTransform(outside, distance, label, cv::DIST_L2, cv::DIST_MASK_5,
                        cv::DIST_LABEL_PIXEL);
  std::vector<int16_t> count_of_label(label.total() + 1);
  for (int v = 0; v < map.height(); ++v) {
    for (int u = 0; u < map.width(); ++u) {
      if (!outside(v, u)) count_of_label[static_cast<size_t>(label(v, u))] = map.counts()(v, u);
    }
  }
  for (int v = 0; v < map.height(); ++v) {
    for (int u = 0; u < map.width(); ++u) {
      if (outside(v, u)) map.counts()(v, u) = count_of_label[static_cast<size_t>(label(v, u))];
    }
  }
}

}  // namespace

Result<DisparityImage> InterpolateSeeds(std::span<const Seed> seeds,
                                        std::span<const SeedTriangle> triangles, cv::Size size) {
  if (seeds.size() < 3) {
    return Fail(std::to_string(seeds.size()) + " seeds: a prior needs at least 3");
  }
  if (triangles.empty()) {
    return Fail(std::to_string(seeds.size()) + " seeds, all on one line: no prior");
  }
  DisparityImage prior(size);
  PaintInBands(size.height, [&](const cv::Range& rows) {
    TriangleRaster raster(size.width, rows);
    for (const auto& [a, b, c] : triangles) {
      PaintTriangle(seeds[static_cast<size_t>(a)], seeds[static_cast<size_t>(b)],
                    seeds[static_cast<size_t>(c)], raster, prior);
    }
  });
  if (prior.CountValid() == 0) return Fail("the seeds' triangles cover no pixel: no prior");
  ExtendBeyondHull(prior);
  return prior;
}

}  // namespace sprout
