#ifndef SPROUT_SERVICES_PRIOR_TRIANGLE_RASTER_H_
#define SPROUT_SERVICES_PRIOR_TRIANGLE_RASTER_H_

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>

#include "common/core/disparity_image.h"
#include "common/core/seed.h"
#include "services/prior/delaunay.h"

namespace sprout {

/// Longest side of an image, px, for which columns and rows in fixed point do not overflow.
inline constexpr int kLargestSide = 1 << 14;

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

/// Takes the disparities away from rows of a map. Unlike cv::Mat::setTo() it allocates nothing.
void Clear(DisparityImage& map, const cv::Range& rows);

/// The pixels of an image whose centre lies in a triangle of seeds or on its border, row by row.
/// Neighbouring triangles both have the pixels of their common edge: none between them is missed.
class TriangleRaster {
 public:
  /// @param width  of the image, px.
  /// @param rows   those that are wanted; others have no runs.
  TriangleRaster(const Seed& a, const Seed& b, const Seed& c, int width, const cv::Range& rows);

  /// The rows that may have pixels: [first_row, end_row); none when end_row ≤ first_row.
  int first_row() const { return first_row_; }
  int end_row() const { return end_row_; }

  /// The pixels of one of these rows; there may be none.
  PixelRun Run(int v) const {
    const Edge& short_edge = static_cast<float>(v) < middle_v_ ? upper_edge_ : lower_edge_;
    const int64_t one = long_edge_.ColumnAt(v);
    const int64_t other = short_edge.ColumnAt(v);
    return {v, Pixel(std::min(one, other) - kSlack + kOne - 1),
            Pixel(std::max(one, other) + kSlack + kOne)};
  }

 private:
  // Columns in fixed point: px with that many more bits. Rounded slopes are off by less than kSlack
  // over the rows of the largest image.
  static constexpr int kFraction = 32;
  static constexpr int64_t kOne = int64_t{1} << kFraction;
  // Runs reach that much beyond their edges, so that rounding never leaves a pixel between
  // triangles.
  static constexpr int64_t kSlack = kOne >> 16;

  // Where an edge of a triangle crosses rows.
  class Edge {
   public:
    Edge() = default;
    Edge(const Seed& top, const Seed& bottom);
    int64_t ColumnAt(int row) const { return column_ + (row - first_row_) * slope_; }

   private:
    static int64_t Fixed(double px, double most_px);

    int first_row_ = 0;  // of those in images
    int64_t column_ = 0;
    int64_t slope_ = 0;
  };

  int Pixel(int64_t column) const {
    return static_cast<int>(std::clamp<int64_t>(column >> kFraction, 0, width_));
  }

  int width_;
  Edge long_edge_;
  Edge upper_edge_;
  Edge lower_edge_;
  float middle_v_ = 0;
  int first_row_ = 0;
  int end_row_ = 0;
};

}  // namespace sprout

#endif  // SPROUT_SERVICES_PRIOR_TRIANGLE_RASTER_H_
