#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/core/disparity_image.h"
#include "services/prior/edges/data_term_kernel.h"
#include "services/prior/triangulation/interpolation.h"

namespace sprout::prior {

/// The surface that some corners of a triangle lie on: at each pixel the plane of the closest one.
class CornerPlanes {
 public:
  void Add(const Plane& plane) { planes_[count_++] = plane; }
  std::span<const Plane> planes() const { return std::span(planes_).first(count_); }

 private:
  std::array<Plane, 3> planes_;
  size_t count_ = 0;
};

/// A triangle across a depth edge: each of its pixels is on one of two surfaces, eq. (P5).
struct EdgeTriangle {
  /// Two rings around a triangle are usually 27.
  static constexpr size_t kMaxSeeds = ColourSeeds::kMaxSeeds;

  SeedTriangle seeds;
  CornerPlanes near;
  CornerPlanes far;
  /// The seeds at the corners and in two rings around; no copies of ExtendBeyondHull().
  std::array<int, kMaxSeeds> nearby_seeds;
  size_t nearby_count = 0;

  std::span<const int> nearby() const { return std::span(nearby_seeds).first(nearby_count); }
};

/// The triangles at whose corners both the disparities and the planes differ by at least `edge_px`.
/// @param planes         of the seeds, and of their copies beyond the hull.
/// @param triangles      of these.
/// @param triangulation  of the seeds.
/// @returns in the order of the triangles.
/// O(triangles); on OpenCV's threads, with the same result for any number.
std::vector<EdgeTriangle> FindEdgeTriangles(std::span<const Plane> planes,
                                            std::span<const SeedTriangle> triangles,
                                            const Triangulation& triangulation, double edge_px);

/// The candidate labels of pixels in triangles across depth edges: two disparities, counts. The
/// near one is DisparityImage::kInvalid where there is no such triangle, and where the surfaces are
/// less than `edge_px` apart: interpolation does no harm there. `far` and `triangle` are undefined
/// there.
struct EdgeLabels {
  cv::Mat1s near;
  cv::Mat1s far;
  cv::Mat1i triangle;  ///< index of the pixel's triangle
};

/// @param labels  overwritten; memory of that size is used again.
/// O(triangles + pixels); on OpenCV's threads, with the same result for any number.
void PaintLabels(std::span<const EdgeTriangle> edges, std::span<const Plane> planes, double edge_px,
                 cv::Size size, EdgeLabels& labels);

/// The census transform (Zabih and Woodfill, ECCV 1994): for each pixel a bit for each of the eight
/// around it, set if that one is darker; 0 on the border. O(pixels); on OpenCV's threads.
/// @param codes  overwritten; memory of that size is used again.
void CensusTransform(const cv::Mat1b& image, cv::Mat1b& codes);

/// The data term E(p, l) of the two labels l of a pixel p, eqs. (P6) and (P7) of the README.
class DataTerm {
 public:
  /// @param images  all arguments except the planes must outlive the object.
  /// @param edges   whose nearby seeds are among the planes.
  /// O(edges), about a kilobyte each; on OpenCV's threads.
  DataTerm(const EdgeImages& images, std::span<const EdgeTriangle> edges,
           std::span<const Plane> planes, const PriorConfig& config);

  /// E(p, far) − E(p, near), without the colours where they cannot change its sign. The same on
  /// every machine. O(1), some hundred operations.
  /// @param triangle   of the pixel, an index of the edges.
  /// @param near, far  its labels, counts.
  double FarMinusNear(int u, int v, int triangle, int near, int far) const;

 private:
  ColourSeeds Gather(std::span<const int> seeds, std::span<const Plane> planes) const;

  const EdgeImages& images_;
  DataTermScales scales_;
  std::unique_ptr<ColourSeeds[]> nearby_;  // one an edge
};

/// Gives each pixel with labels the one of the smaller data term. Every other pixel of every other
/// row is decided first; a pixel whose decided neighbours all have the near, or all the far,
/// surface takes it without evaluating the data term.
/// @param prior  overwritten where there are labels.
/// O(pixels); on OpenCV's threads, with the same result for any number.
void DecideLabels(const EdgeLabels& labels, const DataTerm& data_term, DisparityImage& prior);

/// Enters the labels of the chosen triangles, eq. (P5), in some rows, later ones over earlier ones,
/// where their surfaces are at least `least_gap_px` apart. Computes several pixels of a row at
/// once, with the same bytes on every CPU. O(triangles + pixels).
void PaintEdgeLabels(std::span<const EdgeTriangle> edges, std::span<const int> chosen,
                     std::span<const Plane> planes, float least_gap_px, const cv::Range& rows,
                     EdgeLabels& labels);

}  // namespace sprout::prior
