#pragma once

#include <cstdint>

#include "common/core/disparity_image.h"

namespace sprout {

/// How two disparity maps of one size differ.
struct DisparityDiff {
  int64_t pixels = 0;         ///< of the map
  int64_t differing = 0;      ///< changed, newly valid or newly invalid
  int64_t changed = 0;        ///< valid in both, with another disparity
  int64_t moved = 0;          ///< of the changed ones: by more than 1 px
  int64_t newly_valid = 0;    ///< in B only
  int64_t newly_invalid = 0;  ///< in A only
  double sum_px = 0;          ///< of |b − a| over the changed ones
  double max_px = 0;          ///< largest |b − a|
  cv::Point first{-1, -1};    ///< first differing pixel, row by row

  double mean_px() const { return changed > 0 ? sum_px / static_cast<double>(changed) : 0; }
};

/// @pre both maps have one size. O(pixels).
DisparityDiff Compare(const DisparityImage& a, const DisparityImage& b);

}  // namespace sprout
