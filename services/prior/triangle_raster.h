#ifndef SPROUT_SERVICES_PRIOR_TRIANGLE_RASTER_H_
#define SPROUT_SERVICES_PRIOR_TRIANGLE_RASTER_H_

#include <opencv2/core.hpp>
#include <vector>

#include "common/core/seed.h"
#include "services/prior/delaunay.h"

namespace sprout {

/// Neighbouring pixels of one row: columns [begin, end).
struct PixelRun {
  int v;
  int begin;
  int end;
};

/// The pixels of an image whose centre lies in a triangle of seeds or on its border, row by row.
/// Neighbouring triangles both have the pixels of their common edge: none between them is missed.
class TriangleRaster {
 public:
  explicit TriangleRaster(cv::Size size) : size_(size) {}

  /// @returns runs in order of the rows, some of them empty; valid until the next call.
  /// O(pixels of the triangle's height); takes no memory once it has seen the tallest.
  const std::vector<PixelRun>& Runs(const Seed& a, const Seed& b, const Seed& c);

 private:
  cv::Size size_;
  std::vector<PixelRun> runs_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_TRIANGLE_RASTER_H_
