#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "services/refine/stereo/stereo_search.h"

namespace sprout::refine {

/// The best matches of the pixels of a row, from the path sums of both sweeps. Keeps its memory
/// from row to row.
class BestMatches {
 public:
  /// @param down, up      sums for the row's pixels, AddUpPaths.
  /// @param best          gets the disparity of the smallest sum, px, of every pixel that is
  ///                      searched.
  /// @param confirmed_px  the same with a sub-pixel part, where it is unique and confirmed from the
  /// right image; null: not wanted. Other pixels of both stay as they are.
  /// O(pixels of the row · labels).
  void Choose(const StereoSearch& search, int v, const cv::Range& columns, const uint16_t* down,
              const uint16_t* up, int16_t* best, float* confirmed_px);

 private:
  // The smallest sum of each pixel of the right image, and its disparity.
  std::vector<uint16_t> right_sums_, right_best_;
};

}  // namespace sprout::refine
