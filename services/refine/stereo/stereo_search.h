#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "services/refine/stereo/stereo_rules.h"

namespace sprout::refine {

/// Which disparities semi-global matching searches, and which are known from a range sensor.
struct StereoSearch {
  static constexpr int16_t kNowhere = -1;

  /// Smallest disparity that is searched, px, ≥ 0; kNowhere = the pixel is left out.
  cv::Mat1s first;
  /// Number of disparities searched from `first` on, the labels of the pixel: 16, or a larger
  /// multiple of 16 when `first` is the same at all pixels where it is not kNowhere.
  int labels = StereoRules::kLabels;
  /// Disparity that a range sensor gives for the pixel, px; kNowhere = none.
  cv::Mat1s known;
  /// Whether paths run diagonally, too.
  bool diagonal = true;
  /// Whether matches are to be confirmed, or only the best ones are wanted.
  bool confirm = true;
};

/// In every row the pixels from the first to the last one that is searched: memory and time are
/// proportional to these, not to the whole image.
class SearchRows {
 public:
  /// O(pixels of the image), about 0.3 ns each.
  void Set(const StereoSearch& search);

  int count() const { return static_cast<int>(columns_.size()); }

  /// Empty when the row is left out.
  const cv::Range& columns(int v) const { return columns_[static_cast<size_t>(v)]; }

  /// Number of the pixels that are searched, in all rows.
  size_t pixels() const { return begin_.back(); }

  /// Index of such a pixel, row by row: its labels begin at this index times the labels a pixel in
  /// an array of all labels.
  size_t IndexOf(int v, int u) const {
    return begin_[static_cast<size_t>(v)] + static_cast<size_t>(u - columns(v).start);
  }

 private:
  std::vector<cv::Range> columns_;
  std::vector<size_t> begin_;  // index of the rows' first pixels, and the end of the last
};

}  // namespace sprout::refine
