#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "services/grow/paper/growth_rule.h"

// The fast sweep, steps as the README numbers them: 1 and 2 in vectors, row by row; 3 to 5 on
// segments of rows, which are far fewer than pixels. Bands of rows are worked on at the same time.
namespace sprout::grow {

/// A claim that lost its right pixel to another one.
struct LostClaim {
  int16_t key;
  int16_t u;
  int16_t d;     // px
  int16_t step;  // counts from d to the least cost
};

/// A segment of a row. Linked segments make a tree, in which each comes after its parent.
struct Segment {
  int16_t begin;       // column
  uint8_t is_matched;  // whether its pixels have disparities
  uint8_t is_reached;  // of a root: whether a seed reaches its tree
  int32_t parent;      // the root is its own
};

/// The state of the sweep of a band of rows, besides the map.
struct SweepBand {
  int first_row = 0;
  int rows = 0;

  /// For each row, whether it has an open pixel.
  std::vector<uint8_t> has_open;

  /// Claims that lost in (W2), row by row, and where those of each row begin, one more than rows.
  std::vector<LostClaim> lost;
  std::vector<int32_t> first_lost;

  /// A row of the map is cut into segments: runs of pixels whose disparities differ by at most one
  /// from each to the next; pixels without a disparity make segments, too. Bit u % 64 of word u /
  /// 64 of a row: a segment begins at u > 0.
  std::vector<uint64_t> cuts;
  size_t words_per_row = 0;

  std::vector<Segment> segments;       // of all rows
  std::vector<int32_t> first_segment;  // of each row, one more than rows
};

/// (W1) and (W2) for the rows of a band: fills these rows of the map, the lost claims and cuts.
/// Compiled for each instruction set; all give the same bytes: they compute in whole numbers, and
/// in single operations of floating point that IEEE 754 defines to the last bit. O(pixels).
/// @param band  first_row and rows are set.
using SweepFunction = void (*)(const GrowthRule& rule, const GrowthInput& input, SweepBand& band,
                               DisparityImage& map);

/// The one for the instruction set in use (--simd); null when that has no vectors of 16 bytes.
SweepFunction FindSweep();

}  // namespace sprout::grow
