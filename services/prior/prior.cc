#include "services/prior/prior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "services/prior/delaunay.h"

namespace sprout {
namespace {

// Column at which an edge crosses a row. Both triangles of an edge see the same column, to the
// bit, since the end points are put in order first: no pixel between them is missed.
double CrossingColumn(const Seed& a, const Seed& b, double v) {
  const auto [top, bottom] =
      std::pair(a.v, a.u) < std::pair(b.v, b.u) ? std::pair(a, b) : std::pair(b, a);
  const double share = (v - double{top.v}) / (double{bottom.v} - double{top.v});
  return double{top.u} + share * (double{bottom.u} - double{top.u});
}

// Whole numbers in [first, last], cut to [0, size).
struct PixelRange {
  int begin;
  int end;
};

PixelRange PixelsBetween(double first, double last, int size) {
  const auto clamp = [&](double x) { return static_cast<int>(std::clamp<double>(x, 0, size)); };
  return {clamp(std::ceil(first)), clamp(std::floor(last) + 1)};
}

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

// Paints the pixels whose centre lies in the triangle or on its border. Neighbours both paint their
// common edge, with the same values but for rounding.
void PaintTriangle(std::array<Seed, 3> corners, DisparityImage& map) {
  std::sort(corners.begin(), corners.end(),
            [](const Seed& a, const Seed& b) { return std::pair(a.v, a.u) < std::pair(b.v, b.u); });
  const auto& [top, middle, bottom] = corners;
  const Plane plane = PlaneThrough(top, middle, bottom);
  // Rounding must not carry a pixel in a sliver beyond its corners.
  const auto [least, most] = std::minmax({top.disparity(), middle.disparity(), bottom.disparity()});

  const PixelRange rows = PixelsBetween(top.v, bottom.v, map.height());
  for (int v = rows.begin; v < rows.end; ++v) {
    const double row = v;
    const double long_edge = CrossingColumn(top, bottom, row);
    const double short_edge = row < double{middle.v}   ? CrossingColumn(top, middle, row)
                              : row > double{middle.v} ? CrossingColumn(middle, bottom, row)
                                                       : double{middle.u};
    const auto [left, right] = std::minmax(long_edge, short_edge);
    const PixelRange columns = PixelsBetween(left, right, map.width());
    int16_t* const counts = map.counts()[v];
    for (int u = columns.begin; u < columns.end; ++u) {
      const double disparity = plane.at_origin + plane.per_column * u + plane.per_row * v;
      counts[u] = ToCounts(std::clamp<double>(disparity, least, most));
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

Result<DisparityImage> InterpolateSeeds(std::span<const Seed> seeds, cv::Size size) {
  if (seeds.size() < 3) {
    return Fail(std::to_string(seeds.size()) + " seeds: a prior needs at least 3");
  }
  const std::vector<SeedTriangle> triangles = TriangulateSeeds(seeds);
  if (triangles.empty()) {
    return Fail(std::to_string(seeds.size()) + " seeds, all on one line: no prior");
  }
  DisparityImage prior(size);
  for (const auto& [a, b, c] : triangles) {
    PaintTriangle({seeds[static_cast<size_t>(a)], seeds[static_cast<size_t>(b)],
                   seeds[static_cast<size_t>(c)]},
                  prior);
  }
  if (prior.CountValid() == 0) return Fail("the seeds' triangles cover no pixel: no prior");
  ExtendBeyondHull(prior);
  return prior;
}

}  // namespace sprout
