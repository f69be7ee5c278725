#ifndef SPROUT_SERVICES_PRIOR_TRIANGLE_RASTER_H_
#define SPROUT_SERVICES_PRIOR_TRIANGLE_RASTER_H_

#include <cstdint>
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

/// Rows of an image that a triangle may have pixels in: [begin, end). Bands of rows skip by it the
/// triangles that are none of theirs.
struct RowReach {
  int16_t begin = 0;
  int16_t end = 0;

  bool Meets(const cv::Range& rows) const { return begin < rows.end && rows.start < end; }
};

RowReach ReachOf(const Seed& a, const Seed& b, const Seed& c);

/// The pixels of an image whose centre lies in a triangle of seeds or on its border, row by row.
/// Neighbouring triangles both have the pixels of their common edge: none between them is missed.
class TriangleRaster {
 public:
  /// @param width  of the image, px.
  /// @param rows   those that are wanted; others get no runs.
  TriangleRaster(int width, cv::Range rows) : width_(width), rows_(rows) {}

  /// @returns runs in order of the rows, some of them empty; valid until the next call.
  /// O(pixels of the triangle's height); takes no memory once it has seen the tallest.
  const std::vector<PixelRun>& Runs(const Seed& a, const Seed& b, const Seed& c);

 private:
  int width_;
  cv::Range rows_;
  std::vector<PixelRun> runs_;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_TRIANGLE_RASTER_H_
