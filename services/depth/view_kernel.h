#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sprout::depth {

/// How the pixels of a row of a disparity map are projected into a view: pixel u with depth z is
/// the point origin + z · (start + u · per_u) there.
struct RowProjection {
  std::array<float, 3> origin, start, per_u;
  float focal_px, cx, cy;  ///< of the view
  float metre_counts;      ///< z · (counts + shift), of every pixel with a depth
  float shift;             ///< counts
};

/// Pixels of a row of the map, projected into the view, and the smallest and largest values of each
/// pixel and the next one.
struct ProjectedRow {
  explicit ProjectedRow(size_t width);

  std::vector<float> x, y;    ///< px
  std::vector<float> z;       ///< m; 0: no point, or not in front of the view
  std::vector<float> left_z;  ///< m, in the left frame
  std::vector<float> counts;  ///< of the disparity
  std::vector<float> least_x, most_x, least_y, most_y, least_z, sum_z, least_counts, most_counts;
};

/// Which pixels span a surface, and which pixels of the view it may fill.
struct SpanRule {
  float surface_counts;  ///< largest difference of disparities
  float side_px;         ///< longest side in the view
  float right, bottom;   ///< last column and row of the view
  float counts_per_m;
};

/// Between two rows of the map: of pixels u and u + 1 of both rows at index u.
struct Spans {
  explicit Spans(size_t width);

  /// 1 when they span a surface, 3 when the view sees it from behind: then nothing is on it. One
  /// more in front, and at the end: 0.
  std::vector<uint8_t> surface;
  std::vector<int32_t> u_begin, u_end, v_begin, v_end;  ///< pixels of the view on it
  std::vector<int32_t> value;                           ///< their depth in counts − 1
};

/// @param counts  of row.x.size() pixels.
void ProjectRow(const RowProjection& projection, const int16_t* counts, ProjectedRow& row);
void FindSpans(const ProjectedRow& upper, const ProjectedRow& lower, const SpanRule& rule,
               Spans& spans);

/// 1 for pixels with a depth that are not surrounded by surfaces, nor part of one that the view
/// sees from behind.
/// @param above, below  Spans::surface of the rows above and below.
void FindBorders(const ProjectedRow& row, const std::vector<uint8_t>& above,
                 const std::vector<uint8_t>& below, std::vector<uint8_t>& borders);

/// The smaller of both, pixel by pixel.
void KeepSmaller(const uint16_t* other, size_t count, uint16_t* kept);

}  // namespace sprout::depth
